"""Commands that plugins add to the command line: functions and the help of their parameters, without a parser.

A plugin names a :class:`CommandGroup` in the entry-point group ``driftform.commands``::

    [project.entry-points."driftform.commands"]
    network = "driftform_networks.commands:group"

The name of the entry point is the first word of its commands: ``driftform network show``. Import what the commands need
for their work inside the functions: the module is imported whenever the commands are listed.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from typing import Any

from driftform.errors import InputError, describe_error

ENTRY_POINTS = "driftform.commands"


@dataclass(frozen=True)
class Argument:
    """Describes a positional parameter of a command, as in ``Annotated[str, Argument("FILE", "An EPANET file.")]``."""

    metavar: str
    help: str


@dataclass(frozen=True)
class Option:
    """Describes a parameter that is given by name, such as ``--at HOURS``.

    Attributes
    ----------
    name
        name with dashes, such as ``--at``.
    help
        one sentence.
    metavar
        what stands for the value; empty for a flag.
    least, most
        bounds of a number, ``None`` without a bound.
    """

    name: str
    help: str
    metavar: str = ""
    least: float | None = None
    most: float | None = None


@dataclass(frozen=True)
class TextTable:
    """A table for people: a header, rows of text, and the columns that are flush right."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: Sequence[int] = ()


@dataclass(frozen=True)
class CommandResult:
    """What a command prints.

    Attributes
    ----------
    document
        content of the JSON document that ``--json`` prints.
    text
        lines and tables for people, printed without ``--json``.
    """

    document: Mapping[str, Any]
    text: Sequence[str | TextTable] = ()


@dataclass(frozen=True)
class CommandGroup:
    """Commands under one name.

    Attributes
    ----------
    help
        one sentence.
    commands
        functions by the names of their commands. The docstring of a function is the help of its command. Each parameter
        is annotated with its type (``str``, ``int``, ``float``, ``bool``, ``Path``, a list of these, or one of these
        or ``None``) and with an :class:`Argument` or an :class:`Option`. Every command also has ``--json``.
    """

    help: str
    commands: Mapping[str, Callable[..., CommandResult]]


@dataclass(frozen=True)
class InstalledGroup:
    """A group of commands that a distribution adds, or the reason why it is unavailable.

    Attributes
    ----------
    name
        first word of its commands.
    distribution, version
        name and version of the distribution.
    load
        imports and returns the group.
    """

    name: str
    distribution: str
    version: str
    load: Callable[[], CommandGroup] = field(repr=False)

    @property
    def state(self) -> str:
        """``"ok"``, or the reason why the group is unavailable."""
        try:
            self.load()
        except InputError as error:
            return str(error)
        return "ok"


def find_groups() -> dict[str, InstalledGroup]:
    """Return the groups of commands that plugins add, by name, without importing them."""
    found: dict[str, InstalledGroup] = {}
    for point, distribution, version in _list_points():
        if point.name in found:
            both = f"{found[point.name].distribution} and {distribution}"
            load = _refuse(f"unavailable: claimed by {both}; uninstall one of them")
            found[point.name] = InstalledGroup(point.name, both, version, load)
        else:
            found[point.name] = InstalledGroup(point.name, distribution, version, _load_late(point))
    return found


def _list_points() -> Iterator[tuple[metadata.EntryPoint, str, str]]:
    # One distribution may be found twice on the path of a development environment.
    seen = set()
    for point in sorted(metadata.entry_points(group=ENTRY_POINTS), key=lambda point: point.name):
        distribution, version = (point.dist.name, point.dist.version) if point.dist else ("?", "?")
        if (point.name, distribution) not in seen:
            seen.add((point.name, distribution))
            yield point, distribution, version


def _load_late(point: metadata.EntryPoint) -> Callable[[], CommandGroup]:
    def load() -> CommandGroup:
        try:
            group = point.load()
        except (Exception, SystemExit) as error:
            raise InputError(f"unavailable: {describe_error(error)}") from None
        if not isinstance(group, CommandGroup):
            raise InputError(f"unavailable: {point.value} is not a CommandGroup")
        return group

    return load


def _refuse(reason: str) -> Callable[[], CommandGroup]:
    def load() -> CommandGroup:
        raise InputError(reason)

    return load
