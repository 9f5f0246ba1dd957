"""The sources of the keys of a study: a file, the files it is based on, and options of the command line.

Each source is a layer that overrides those before it. An error names the source that set the key.
"""

import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from importlib import resources
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from driftform.errors import InputError, did_you_mean
from driftform.interfaces import SEAMS
from driftform.plugins.discovery import find_modules
from driftform.study.toml_positions import KeyPath, check_keys, describe_fault, find_key_lines, find_line
from driftform.util.files import is_directory, is_file, read_text
from driftform.water.flow import FLOWS

P = ParamSpec("P")
T = TypeVar("T")

REPLACED = ("targets",)
"""Tables of a study file that replace those of its base instead of extending them; ``--set targets.name=...`` extends."""

FILES = (("flow", "file"), ("builder", "core"))
"""Tables and keys that name a file, relative to the folder of the study file."""

CALIBRATION = "calibration"
"""The table that ``driftform calibrate`` writes."""

SCENARIOS = "driftform.builtin.scenarios"
"""The package of the built-in scenario files."""


@dataclass(frozen=True)
class Source:
    """One source of keys: a file, of which ``text`` is the content, or an option; ``label`` names it in errors."""

    label: str
    data: Mapping[str, Any]
    is_option: bool = False
    replaces: Sequence[str] = REPLACED
    text: str = ""

    def holds(self, path: KeyPath) -> bool:
        """Return whether this source sets the key."""
        return find_value(self.data, path) is not NOTHING

    def locate(self, path: KeyPath) -> str:
        """Return the label of the source, with the line of the key if it is a file."""
        line = find_line(path, find_key_lines(self.text))
        return f"{self.label}:{line}" if line else self.label


NOTHING = object()
"""What :func:`find_value` returns for a missing key."""


def find_value(node: Any, path: KeyPath) -> Any:
    """Return the value at a path, ``NOTHING`` if the path does not exist."""
    for name in path:
        # A table may hold an item of a list by its number: see 'merge_source'.
        key = str(name) if isinstance(node, Mapping) else name
        listed = isinstance(node, list | tuple) and isinstance(key, int) and key < len(node)
        if not listed and not (isinstance(node, Mapping) and key in node):
            return NOTHING
        node = node[key]
    return node


def join_path(path: KeyPath) -> str:
    """Return a key in readable form, such as ``pipe.segments[0].radius``."""
    return "".join(f"[{name}]" if isinstance(name, int) else f".{name}" for name in path).removeprefix(".")


def read_scenarios() -> dict[str, str]:
    """Return the text of the scenario files of driftform and of its plugins, by name.

    A plugin contributes a package of such files by the hook ``driftform_scenarios``. If two files have the same name,
    that of driftform is taken, or else that of the entry point whose name sorts first.
    """
    hooks = (plugin.find_hook("driftform_scenarios") for plugin in find_modules())
    found: dict[str, str] = {}
    for package in (SCENARIOS, *(hook() for hook in hooks if hook is not None)):
        try:
            folder = resources.files(package)
        except ImportError:
            # A broken plugin must not affect others.
            continue
        for entry in sorted(folder.iterdir(), key=lambda e: e.name):
            if entry.name.endswith(".toml"):
                found.setdefault(entry.name.removesuffix(".toml"), entry.read_text(encoding="utf-8"))
    return found


def read_sources(source: str, above: tuple[str, ...] = (), named_by: str = "") -> list[Source]:
    """Read a study file or a built-in scenario, and the files it is based on; the last source is the file itself.

    ``above`` are the files whose ``base`` led to this file, and ``named_by`` is the place of the last ``base``.

    Raises InputError if a file is missing, cannot be read, is not TOML, or is based on itself.
    """
    builtins = read_scenarios()
    path = Path(source)
    if source in builtins and not is_file(path):
        label, text = f"{source} (built in)", builtins[source]
    elif is_file(path):
        label, text = str(path), read_text(path)
    elif source and is_directory(path):
        raise InputError(f"{named_by}study '{source}' is a directory, expected a TOML file")
    else:
        hint = did_you_mean(source, builtins)
        if not source.isprintable():
            hint = "; a backslash in double quotes is a code, such as \\t for a tab: write / in its place"
        raise InputError(f"{named_by}study {source!r} is neither a file nor a built-in scenario{hint}")
    key = str(path.resolve()) if is_file(path) else label
    if key in above:
        raise InputError(f"{named_by}'base' leads back to {label}")
    layer = parse_text(label, text)
    data = dict(layer.data)
    for table, option in FILES:
        options = data.get(table)
        if isinstance(options, Mapping) and isinstance(name := options.get(option), str):
            # Such a file lies in the folder of the study that names it; a core may be a ball by name, too.
            sibling = path.parent / name
            if table == "flow" or is_file(sibling):
                data[table] = {**options, option: str(sibling)}
    layer = replace(layer, data=data)
    base = data.get("base")
    if base is None:
        return [layer]
    if not isinstance(base, str):
        raise InputError(f"{layer.locate(('base',))}: base = {base!r} is not the name of a scenario or file")
    sibling = path.parent / base
    named_by = f"{layer.locate(('base',))}: "
    return [*read_sources(str(sibling) if is_file(sibling) else base, (*above, key), named_by), layer]


def read_calibration(path: str) -> Source:
    """Read a file with the table ``[calibration]``, which replaces that of a study.

    Raises InputError if there is no such file, or it holds something else.
    """
    if not is_file(Path(path)):
        raise InputError(f"--calibration {path}: is not a file; 'driftform calibrate' writes one")
    layer = parse_text(path, read_text(Path(path)))
    if set(layer.data) != {CALIBRATION}:
        raise InputError(f"{path}: should hold the table [{CALIBRATION}] and nothing else")
    return replace(layer, is_option=True, replaces=(CALIBRATION,))


def parse_text(label: str, text: str) -> Source:
    """Parse a TOML file; an InputError names it by its label, and the line that is wrong."""
    try:
        check_keys(text)
        data = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{label}: is not valid TOML: nested too deeply") from None
    except ValueError as error:
        raise InputError(describe_fault(label, text, error)) from None
    return Source(label, data, text=text)


def parse_setting(text: str) -> Source:
    """Parse ``key=value`` of the command line: a dotted key and a TOML value; any other value is text.

    Raises InputError if the text does not have this form.
    """
    key, equals, value = text.partition("=")
    names = [name.strip() for name in key.split(".")]
    if not equals or not all(names):
        raise InputError(f"--set {text}: expected key=value, such as flow.speed=0.8")
    if key.strip() == "base":
        raise InputError(f"--set {text}: a base is a line of a study file; name that scenario in place of the study")
    try:
        check_keys(text)
    except ValueError as error:
        raise InputError(f"--set {text[:40]}...: {error}") from None
    try:
        parsed: Any = tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        # In TOML a number has digits on both sides of its point.
        parsed = float(value) if re.fullmatch(r"\s*[+-]?(\.\d+|\d+\.)\s*", value) else value.strip()
    for name in reversed(names):
        parsed = {name: parsed}
    replaces = REPLACED if len(names) == 1 else ()
    return Source(f"--set {text}", parsed, is_option=True, replaces=replaces)


def say_in_python(function: Callable[P, T]) -> Callable[P, T]:
    """Return the function, with errors that name its arguments instead of the options of commands."""

    @wraps(function)
    def call(*args: P.args, **given: P.kwargs) -> T:
        try:
            return function(*args, **given)
        except InputError as error:
            if not error.in_options:
                error.args, error.in_options = tuple(map(_name_argument, error.args)), error.args
            raise

    return call


def _name_argument(line: object) -> str:
    text = re.sub(r"^--set (.*?): ", r"settings: '\1': ", str(line))
    text = re.sub(r"^--(target|calibration) (.*?): ", r"\1: '\2': ", text)
    return re.sub(r"^--(\w+): ", lambda found: f"{'use' if found[1] in SEAMS else 'run'}['{found[1]}']: ", text)


def merge_source(below: Mapping[str, Any], source: Source) -> dict[str, Any]:
    """Return ``below`` overridden by the keys of a source: tables are merged key by key, other values are replaced.

    A table whose keys are numbers is merged into a list item by item. A table that the source ``replaces`` is replaced as
    a whole. So is a table that selects another plugin, but for the options that every plugin of its seam has; a table that
    selects another ``kind`` loses the keys that only the former kind has.

    Raises InputError if the source sets an item that its list does not have.
    """

    def merge_tables(old: Mapping[str, Any], new: Mapping[str, Any], path: KeyPath) -> dict[str, Any]:
        return {**old, **{key: merge_values(old.get(key), value, (*path, key)) for key, value in new.items()}}

    def merge_values(old: Any, value: Any, path: KeyPath) -> Any:
        if len(path) == 1 and path[0] in source.replaces:
            return value
        # A place in a pipe is a table in place of coordinates.
        if isinstance(old, list) and isinstance(value, Mapping) and value and "part" not in value:
            return merge_items(old, value, path)
        if not (isinstance(old, Mapping) and isinstance(value, Mapping)):
            return value
        if len(path) == 1:
            old = _drop_other_options(str(path[0]), old, value)
        return merge_tables(old, value, path)

    def merge_items(old: list[Any], value: Mapping[str, Any], path: KeyPath) -> list[Any]:
        items = list(old)
        for name, item in value.items():
            if not (name.isdecimal() and int(name) < len(items)):
                known = f"its items are 0 to {len(items) - 1}" if items else "it has no items"
                raise InputError(f"{source.locate(path)}: {'.'.join(map(str, path))} has no item '{name}'; {known}")
            items[int(name)] = merge_values(items[int(name)], item, (*path, int(name)))
        return items

    return merge_tables(below, source.data, ())


def _drop_other_options(table: str, old: Mapping[str, Any], above: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the keys of a table that are valid for the plugin or the kind that ``above`` selects, too."""
    if "use" in above and above["use"] != old.get("use"):
        shared = SEAMS[table].Options.model_fields if table in SEAMS else {}
        return {key: value for key, value in old.items() if key in shared}
    kinds = {"flow": FLOWS}.get(table, {})
    former, chosen = kinds.get(str(old.get("kind", "uniform"))), kinds.get(str(above.get("kind")))
    if former is None or chosen is None:
        return old
    dropped = former.model_fields.keys() - chosen.model_fields.keys()
    return {key: value for key, value in old.items() if key not in dropped}


def locate_key(layers: Sequence[Source], path: KeyPath) -> str:
    """Return the place of a key: the last source that sets it; for a missing key, the file or document itself."""
    for layer in reversed(layers):
        if path and layer.holds(path):
            return layer.locate(path)
    return next(layer for layer in reversed(layers) if not layer.is_option).locate(path)
