"""Finds the modules of plugins through the entry-point group ``driftform``; imports nothing else of them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import metadata
from typing import Any

import pluggy

from driftform.errors import describe_error

GROUP = "driftform"
"""The group of entry points; the name of each hook begins with it."""

hookimpl = pluggy.HookimplMarker(GROUP)
"""Marks a function of a plugin module as the implementation of a hook of :mod:`driftform.plugins.hookspecs`."""


@dataclass(frozen=True)
class PluginModule:
    """A module with hooks that a distribution names.

    Attributes:
        name: of its entry point.
        place: what the entry point names, such as ``driftform_native``.
        distribution, version: name and version of its distribution.
        module: the module, ``None`` if it cannot be imported.
        problem: the reason why it cannot be imported.
    """

    name: str
    place: str
    distribution: str
    version: str
    module: Any = None
    problem: str = ""

    def find_hook(self, hook: str) -> Callable[..., Any] | None:
        """Return its implementation of a hook, such as ``driftform_commands``, ``None`` if it has none."""
        found = getattr(self.module, hook, None)
        return found if hasattr(found, f"{GROUP}_impl") else None


def find_modules() -> Iterator[PluginModule]:
    """Yield the modules of all installed plugins, by the names of their entry points; broken ones with the reason."""
    # One distribution may be found twice on the path of a development environment.
    seen = set()
    for point in sorted(metadata.entry_points(group=GROUP), key=lambda p: p.name):
        distribution, version = (point.dist.name, point.dist.version) if point.dist else ("?", "?")
        if (point.name, distribution) in seen:
            continue
        seen.add((point.name, distribution))
        origin = (point.name, point.value, distribution, version)
        try:
            yield PluginModule(*origin, point.load())
        except (Exception, SystemExit) as error:
            yield PluginModule(*origin, problem=f"unavailable: {describe_error(error)}")
