"""driftform plugin: agents in the water network of a town, where they go and what they see.

Importing this package imports nothing heavy: its functions are imported when they are first asked for.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from driftform_networks.api import trace
    from driftform_networks.reading import open_network

__all__ = ["open_network", "trace"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'driftform_networks' has no attribute '{name}'")
    from driftform_networks import api, reading

    return getattr(reading if name == "open_network" else api, name)
