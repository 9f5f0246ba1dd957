"""A roscore."""

import shutil

import pytest
from ros1 import run_master


@pytest.fixture(scope="session")
def system(tmp_path_factory):
    """The environment of programs of the system; without ROS the test is skipped."""
    if shutil.which("roscore") is None:
        pytest.skip("roscore is not installed")
    home = tmp_path_factory.mktemp("home")
    return {"PATH": "/usr/bin:/bin", "HOME": str(home), "ROS_HOME": str(home), "LC_ALL": "C.UTF-8"}


@pytest.fixture(scope="module")
def master(system):
    with run_master(system) as (found, _):
        yield found
