"""driftform: evolve the shape of a passive underwater agent so that the current alone carries it.

The data flow is ``genome -> morphology -> body -> coefficients -> trajectory -> fitness``;
:mod:`driftform.pipeline` reads top to bottom like that line. Importing this package imports nothing heavy: what it
offers to notebooks and scripts, :mod:`driftform.api`, is imported when it is first asked for.
"""

from typing import TYPE_CHECKING, Any

import pluggy

if TYPE_CHECKING:
    from driftform.api import agent, evolve, export_flow, load_study, open_run

__version__ = "0.1.0"

hookimpl = pluggy.HookimplMarker("driftform")
"""Marks a function of a plugin module as the implementation of a hook of :mod:`driftform.plugins.hookspecs`."""

__all__ = [
    "__version__",
    "agent",
    "evolve",
    "export_flow",
    "hookimpl",
    "load_study",
    "open_run",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'driftform' has no attribute '{name}'")
    from driftform import api

    return getattr(api, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
