"""driftform plugin: agents in the water network of a town, where they go and what they see.

Its rooms, each of which imports only those before it: ``hydraulics`` (EPANET's flows), ``passages`` (routing tables, and
where bodies go by them), ``flights`` (the tables that flights give), ``planning`` (fleets and inspections), ``output``.
Importing this package imports nothing heavy: its functions are imported when they are first asked for.
"""

from typing import TYPE_CHECKING

import lazy_loader

from driftform import hookimpl

if TYPE_CHECKING:
    import typer

# Without its __dir__, which would hide the hook.
__getattr__, _, __all__ = lazy_loader.attach_stub(__name__, __file__)


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform network``."""
    from driftform_networks import commands

    app.add_typer(commands.app, name="network", rich_help_panel="Water networks")
