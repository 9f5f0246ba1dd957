"""A folder that all processes of one test session share."""

import os


def shared_folder(factory, name):
    """Return a folder of the session, the same in all workers of pytest-xdist: flights that one has made serve the others."""
    base = factory.getbasetemp()
    return (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / name
