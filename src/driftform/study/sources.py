"""Where a study's keys come from: a file, the files it starts from, options of the command line.

Each source is a layer, laid over those before it; an error names the one that had the last word on a key.
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import metadata, resources
from pathlib import Path
from typing import Any

from driftform.errors import InputError, did_you_mean
from driftform.study.toml_positions import Path as KeyPath
from driftform.study.toml_positions import find_key_lines, find_line
from driftform.util.files import is_directory, is_file

REPLACED = ("targets",)
"""Tables that a study file states anew instead of adding to those of its base; ``--set targets.name=...`` adds."""

SCENARIOS = "driftform.scenarios"
"""The package of driftform's own scenario files, and the group of entry points by which plugins bring theirs."""


@dataclass(frozen=True)
class Source:
    """One source of keys: a file, or an option of the command line; ``label`` names it in errors."""

    label: str
    data: Mapping[str, Any]
    lines: Mapping[KeyPath, int] = field(default_factory=dict)
    is_option: bool = False
    replaces: Sequence[str] = REPLACED

    def holds(self, path: KeyPath) -> bool:
        """True where the layer has the key."""
        return find_value(self.data, path) is not NOTHING

    def locate(self, path: KeyPath) -> str:
        """The layer's label, with the line of the key if it is a file."""
        line = find_line(path, self.lines)
        return f"{self.label}:{line}" if line else self.label


NOTHING = object()


def find_value(node: Any, path: KeyPath) -> Any:
    """What stands at a path, ``NOTHING`` where nothing does."""
    for name in path:
        listed = isinstance(node, list | tuple) and isinstance(name, int) and name < len(node)
        if not listed and not (isinstance(node, Mapping) and name in node):
            return NOTHING
        node = node[name]
    return node


def join_path(path: KeyPath) -> str:
    """A key as a person writes it, such as ``pipe.segments[0].radius``."""
    return "".join(f"[{name}]" if isinstance(name, int) else f".{name}" for name in path).removeprefix(".")


def read_scenarios() -> dict[str, str]:
    """Text of the scenario files of driftform and of its plugins, by name.

    A plugin brings a package of them by an entry point of the group ``driftform.scenarios``. Of two files that have
    one name, driftform's own counts, or that of the entry point whose name is the first.
    """
    points = metadata.entry_points(group=SCENARIOS)
    found: dict[str, str] = {}
    for package in (SCENARIOS, *(point.value for point in sorted(points, key=lambda p: p.name))):
        try:
            folder = resources.files(package)
        except ImportError:
            # What is wrong with a plugin is told by 'driftform plugins', and must not stand in the way of others.
            continue
        for entry in sorted(folder.iterdir(), key=lambda e: e.name):
            if entry.name.endswith(".toml"):
                found.setdefault(entry.name.removesuffix(".toml"), entry.read_text(encoding="utf-8"))
    return found


def read_sources(source: str, above: tuple[str, ...] = (), named_by: str = "") -> list[Source]:
    """Read a study file or a built-in scenario, and the files it starts from; the last layer is the file itself.

    ``above`` are the files that led here by their ``base``, and ``named_by`` where the last of them says so.

    Raises
    ------
    InputError
        where a file is not there, cannot be read, is not TOML, or starts from itself.
    """
    builtins = read_scenarios()
    path = Path(source)
    if source in builtins and not is_file(path):
        label, text = f"{source} (built in)", builtins[source]
    elif is_file(path):
        label, text = str(path), _read(path)
    elif source and is_directory(path):
        raise InputError(f"{named_by}study '{source}' is a directory, expected a TOML file")
    else:
        hint = did_you_mean(source, builtins)
        raise InputError(f"{named_by}study '{source}' is neither a file nor a built-in scenario{hint}")
    key = str(path.resolve()) if is_file(path) else label
    if key in above:
        raise InputError(f"{named_by}'base' leads back to {label}")
    try:
        data = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{label}: is not valid TOML: nested too deeply") from None
    except ValueError as error:
        raise InputError(f"{label}: is not valid TOML: {error}") from None
    layer = Source(label, data, find_key_lines(text))
    base = data.get("base")
    if base is None:
        return [layer]
    if not isinstance(base, str):
        raise InputError(f"{layer.locate(('base',))}: base = {base!r} is not the name of a scenario or file")
    beside = path.parent / base
    named_by = f"{layer.locate(('base',))}: "
    return [*read_sources(str(beside) if is_file(beside) else base, (*above, key), named_by), layer]


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not a text file in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def parse_setting(text: str) -> Source:
    """Read ``key=value`` of the command line: a dotted key and a TOML value, or else text.

    Raises
    ------
    InputError
        where it is not of this form.
    """
    key, equals, value = text.partition("=")
    names = [name.strip() for name in key.split(".")]
    if not equals or not all(names):
        raise InputError(f"--set {text}: expected key=value, such as flow.speed=0.8")
    try:
        parsed: Any = tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        parsed = value.strip()
    for name in reversed(names):
        parsed = {name: parsed}
    replaces = REPLACED if len(names) == 1 else ()
    return Source(f"--set {text}", parsed, is_option=True, replaces=replaces)


def merge(below: Mapping[str, Any], above: Mapping[str, Any], replaced: Sequence[str] = ()) -> dict[str, Any]:
    """Lay one document over another: tables are merged key by key, all else is replaced.

    A table is replaced as a whole where it is one of ``replaced``, or chooses another plugin than the one below:
    the options of the one below are not for it.
    """
    result = dict(below)
    for key, value in above.items():
        old = result.get(key)
        both = isinstance(old, Mapping) and isinstance(value, Mapping)
        other_plugin = both and "use" in value and value["use"] != old.get("use")  # type: ignore[union-attr]
        if both and not other_plugin and key not in replaced:
            result[key] = merge(old, value)  # type: ignore[arg-type]
        else:
            result[key] = value
    return result


def locate_key(layers: Sequence[Source], path: KeyPath) -> str:
    """Name the source that had the last word on a key; without a key, the file or document itself."""
    for layer in reversed(layers):
        if path and layer.holds(path):
            return layer.locate(path)
    return next(layer for layer in reversed(layers) if not layer.is_option).locate(path)
