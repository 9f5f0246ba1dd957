"""driftform plugin: agents in the water network of a town, where they go and what they see.

Importing this package imports nothing heavy: its functions are imported when they are first asked for.
"""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    import typer

    from driftform_networks.api import route, trace
    from driftform_networks.bodies import open_traveller
    from driftform_networks.fleets import plan_fleet
    from driftform_networks.reading import open_network

_MODULES = {
    "open_network": "reading",
    "open_traveller": "bodies",
    "plan_fleet": "fleets",
    "route": "api",
    "trace": "api",
}

__all__ = ["open_network", "open_traveller", "plan_fleet", "route", "trace"]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'driftform_networks' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(f"driftform_networks.{_MODULES[name]}"), name)


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform network``."""
    from driftform_networks import commands

    app.add_typer(commands.app, name="network")
