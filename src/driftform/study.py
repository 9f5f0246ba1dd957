"""What to evolve: a TOML document -> scenario, plugins with their options, seed and budget; all checked.

A study file holds the scenario's tables (``[pipe]``, ``[flow]``, ``[targets]`` ...), a table for each seam
(``[simulator] use = "exudyn"``, the rest being that plugin's options), one for each exporter whose options differ
from their defaults (``[exporter.stl]``), and ``[run]``. With ``base`` it starts from
another file, or from a built-in scenario, and says only what differs. Built-in scenarios are study files.
"""

import re
import secrets
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from driftform.errors import InputError, did_you_mean
from driftform.files import is_directory, is_file
from driftform.interfaces import SEAMS, Exporter, SearchSpace, Strategy
from driftform.options import Table, option
from driftform.pipeline import Pipeline
from driftform.registry import registry
from driftform.scenario import Scenario
from driftform.toml_lines import Path as KeyPath
from driftform.toml_lines import key_lines, line_of

DEFAULT = "pipe-inspection"

SELECTED = tuple(seam for seam in SEAMS if seam != "exporter")
"""The seams that a study selects one plugin for."""

REPLACED = ("targets",)
"""Tables that a study file states anew instead of adding to those of its base; ``--set targets.name=...`` adds."""

_LONGEST_NAME = 100
"""Characters of a target's name: with its file's suffix it must fit where file names may have 255 bytes."""


class Run(Table):
    """How much to do, from where, and what to make of the best."""

    seed: int | None = option(
        None, "seed of all randomness; drawn and recorded where none is given", ge=0, strict=True
    )
    evaluations: int | None = option(
        None, "flights in the whole run; by default 50 for each target", "", gt=0, strict=True
    )
    formats: tuple[str, ...] = option(("stl",), "files to export for the best agent of each target")


@dataclass(frozen=True, eq=False)
class Study:
    """A checked study.

    Attributes
    ----------
    document
        the whole document with every default filled in: what ``resolved.toml`` and worker processes get.
    scenario
        the environment.
    run
        seed (never ``None`` here), budget (``None`` only without a strategy) and formats.
    """

    document: Mapping[str, Any]
    scenario: Scenario
    run: Run

    @property
    def seed(self) -> int:
        """The seed of all randomness."""
        assert self.run.seed is not None
        return self.run.seed

    @property
    def evaluations(self) -> int:
        """Flights in the whole run."""
        assert self.run.evaluations is not None
        return self.run.evaluations

    def plugin(self, seam: str) -> Any:
        """Make the plugin selected for a seam (not for ``strategy``, which needs a search space)."""
        return registry().create(seam, *_selection(self.document, seam))

    def pipeline(self) -> Pipeline:
        """The steps from genome to fitness."""
        steps = {seam: self.plugin(seam) for seam in SELECTED if seam != "strategy"}
        return Pipeline(scenario=self.scenario, **steps)

    def strategy(self) -> Strategy[Any]:
        """A fresh strategy, at the beginning of its random numbers."""
        space = SearchSpace(
            self.plugin("grammar"), self.scenario.target_names, np.random.default_rng(self.seed)
        )
        strategy: Strategy[Any] = registry().create(
            "strategy", *_selection(self.document, "strategy"), space=space
        )
        return strategy

    def exporter(self, name: str) -> Exporter[Any]:
        """Make an exporter with the options of its table ``[exporter.<name>]``, if there is one."""
        exporter: Exporter[Any] = registry().create(
            "exporter", name, self.document.get("exporter", {}).get(name, {})
        )
        return exporter

    def environment(self) -> dict[str, Any]:
        """The part of the document that decides how an agent is built and flies: all but strategy and run."""
        return {key: value for key, value in self.document.items() if key not in ("strategy", "run")}


@dataclass(frozen=True, eq=False)
class Document:
    """A study's document that was read from elsewhere than a TOML file; ``label`` names it in errors."""

    label: str
    data: Mapping[str, Any]


@dataclass(frozen=True)
class _Layer:
    """One source of keys: a file, or an option of the command line."""

    label: str
    data: Mapping[str, Any]
    lines: Mapping[KeyPath, int] = field(default_factory=dict)
    is_option: bool = False
    replaces: Sequence[str] = REPLACED

    def holds(self, path: KeyPath) -> bool:
        return _value(self.data, path) is not _NOTHING

    def where(self, path: KeyPath) -> str:
        line = line_of(path, self.lines)
        return f"{self.label}:{line}" if line else self.label


_NOTHING = object()


def _value(node: Any, path: KeyPath) -> Any:
    """What stands at a path, ``_NOTHING`` where nothing does."""
    for name in path:
        listed = isinstance(node, list | tuple) and isinstance(name, int) and name < len(node)
        if not listed and not (isinstance(node, Mapping) and name in node):
            return _NOTHING
        node = node[name]
    return node


def _dotted(path: KeyPath) -> str:
    return "".join(f"[{name}]" if isinstance(name, int) else f".{name}" for name in path).removeprefix(".")


def builtin_scenarios() -> dict[str, str]:
    """Text of the built-in scenario files, by name."""
    folder = resources.files("driftform.scenarios")
    return {
        entry.name.removesuffix(".toml"): entry.read_text(encoding="utf-8")
        for entry in sorted(folder.iterdir(), key=lambda e: e.name)
        if entry.name.endswith(".toml")
    }


def load_study(
    source: "str | Document | None" = None,
    settings: Sequence[str] = (),
    *,
    targets: Sequence[str] = (),
    use: Mapping[str, str | None] | None = None,
    run: Mapping[str, Any] | None = None,
) -> Study:
    """Read, merge and check a study.

    Parameters
    ----------
    source
        path of a TOML file, the name of a built-in scenario, or a document that an agent or run file holds;
        ``None`` for the default scenario.
    settings
        ``key=value`` with a dotted key and a TOML value, laid over the file.
    targets
        keep only these targets; empty for all.
    use
        plugin by seam, where it is not ``None``.
    run
        values of ``[run]``, where they are not ``None``.

    Raises
    ------
    InputError
        one line for each thing that is wrong: file, line, key, value, and the next step.
    """
    if isinstance(source, Document):
        layers = [_Layer(source.label, source.data)]
    else:
        layers = _file_layers(DEFAULT if source is None else source, ())
    for seam, name in (use or {}).items():
        if name is not None:
            layers.append(_Layer(f"--{seam}", {seam: {"use": name}}, is_option=True))
    layers.extend(_setting(text) for text in settings)
    for key, value in (run or {}).items():
        if value is not None:
            layers.append(_Layer(f"--{key}", {"run": {key: value}}, is_option=True))
    document: dict[str, Any] = {}
    for layer in layers:
        document = _merged(document, layer.data, layer.replaces)
    # A document may come from an agent file: what is there to fly needs no strategy.
    required = [seam for seam in SELECTED if seam != "strategy" or not isinstance(source, Document)]
    return _checked(document, layers, targets, required)


def _file_layers(source: str, above: tuple[str, ...], named_by: str = "") -> list[_Layer]:
    builtins = builtin_scenarios()
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
    layer = _Layer(label, data, key_lines(text))
    base = data.get("base")
    if base is None:
        return [layer]
    if not isinstance(base, str):
        raise InputError(f"{layer.where(('base',))}: base = {base!r} is not the name of a scenario or file")
    beside = path.parent / base
    named_by = f"{layer.where(('base',))}: "
    return [*_file_layers(str(beside) if is_file(beside) else base, (*above, key), named_by), layer]


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not a text file in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _setting(text: str) -> _Layer:
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
    return _Layer(f"--set {text}", parsed, is_option=True, replaces=replaces)


def _merged(
    below: Mapping[str, Any], above: Mapping[str, Any], replaced: Sequence[str] = ()
) -> dict[str, Any]:
    result = dict(below)
    for key, value in above.items():
        old = result.get(key)
        both = isinstance(old, Mapping) and isinstance(value, Mapping)
        other_plugin = both and "use" in value and value["use"] != old.get("use")  # type: ignore[union-attr]
        if both and not other_plugin and key not in replaced:
            result[key] = _merged(old, value)  # type: ignore[arg-type]
        else:
            result[key] = value
    return result


def _checked(
    document: Mapping[str, Any], layers: Sequence[_Layer], wanted: Sequence[str], required: Sequence[str]
) -> Study:
    known = {"title", "description", "base", "run", "exporter", *Scenario.model_fields, *SELECTED}
    errors = [
        f"{_where(layers, (key,))}: unknown key '{key}'{did_you_mean(key, known)}"
        for key in document
        if key not in known
    ]
    for key in known - {"title", "description", "base"}:
        if key in document and not isinstance(document[key], Mapping):
            errors.append(f"{_where(layers, (key,))}: {key} = {document[key]!r} is not a table")
    for key in ("title", "description"):
        if not isinstance(document.get(key, ""), str):
            errors.append(f"{_where(layers, (key,))}: {key} = {document[key]!r}: should be text in quotes")
    if errors:
        raise InputError(*errors)

    scenario: Scenario | None = None
    run: Run | None = None
    try:
        scenario = Scenario.model_validate({k: v for k, v in document.items() if k in Scenario.model_fields})
    except ValidationError as error:
        errors += _lines(error, (), Scenario, document, layers)
    try:
        run = Run.model_validate(document.get("run", {}))
    except ValidationError as error:
        errors += _lines(error, ("run",), Run, document, layers)
    resolved: dict[str, Any] = {}
    unselected = [seam for seam in required if "use" not in document.get(seam, {})]
    if unselected:
        tables = ", ".join(f"[{seam}]" for seam in unselected)
        where = _where(layers, (unselected[0],) if len(unselected) == 1 else ())
        errors.append(
            f'{where}: no plugin is chosen by {tables}; give it a line such as use = "..." '
            f"(see 'driftform plugins'), or start the study with base = \"{DEFAULT}\""
        )
    for seam in SELECTED:
        if seam in unselected or seam not in document:
            continue
        try:
            resolved[seam] = _resolved_selection(document, seam, layers)
        except InputError as error:
            errors.extend(error.args)
    exporters: dict[str, Any] = {}
    for name, options in document.get("exporter", {}).items():
        try:
            exporters[name] = _resolved_options(document, ("exporter", name), name, options, layers)
        except InputError as error:
            errors.extend(error.args)
    if errors or scenario is None or run is None:
        raise InputError(*errors)
    _check_folders(scenario, layers)
    scenario = _with_targets(scenario, wanted)
    run = _with_budget(run, scenario, resolved)
    for index, name in enumerate(run.formats):
        try:
            registry().find("exporter", name)
        except InputError as error:
            raise InputError(f"{_where(layers, ('run', 'formats', index))}: {error}") from None
    head = {key: document[key] for key in ("title", "description") if key in document}
    resolved = {**head, **_plain(scenario), **resolved, "exporter": exporters, "run": _plain(run)}
    return Study(resolved, scenario, run)


def _resolved_selection(document: Mapping[str, Any], seam: str, layers: Sequence[_Layer]) -> dict[str, Any]:
    name, options = _selection(document, seam)
    return {"use": name, **_resolved_options(document, (seam,), name, options, layers)}


def _resolved_options(
    document: Mapping[str, Any], path: tuple[str, ...], name: str, options: Any, layers: Sequence[_Layer]
) -> dict[str, Any]:
    """Check the options of the plugin ``name`` that stand in the table ``path``, whose first part is the seam."""
    try:
        cls = registry().find(path[0], name)
    except InputError as error:
        key = (*path, "use") if path[0] in SELECTED else path
        raise InputError(f"{_where(layers, key)}: {error}") from None
    if not isinstance(options, Mapping):
        raise InputError(f"{_where(layers, path)}: {'.'.join(path)} = {options!r} is not a table")
    try:
        checked = cls.Options.model_validate(options)
    except ValidationError as error:
        raise InputError(*_lines(error, path, cls.Options, document, layers)) from None
    return _plain(checked)


def _selection(document: Mapping[str, Any], seam: str) -> tuple[str, dict[str, Any]]:
    options = dict(document[seam])
    return str(options.pop("use")), options


def _check_folders(scenario: Scenario, layers: Sequence[_Layer]) -> None:
    """Refuse names of targets that are too long for a folder, or one folder on some file systems."""
    seen: dict[str, str] = {}
    for name in scenario.targets:
        where = _where(layers, ("targets", name))
        if len(name.encode()) > _LONGEST_NAME:
            raise InputError(
                f"{where}: target name '{name[:20]}...' is longer than {_LONGEST_NAME} bytes: it names a folder"
            )
        if name.casefold() in seen:
            raise InputError(
                f"{where}: target names '{seen[name.casefold()]}' and '{name}' differ in case only: "
                "some file systems cannot tell their folders apart"
            )
        seen[name.casefold()] = name


def _with_targets(scenario: Scenario, wanted: Sequence[str]) -> Scenario:
    for name in wanted:
        if name not in scenario.targets:
            raise InputError(
                f"--target {name}: the scenario has no such target{did_you_mean(name, scenario.targets)}"
            )
    if not wanted:
        return scenario
    kept = {name: point for name, point in scenario.targets.items() if name in wanted}
    return scenario.model_copy(update={"targets": kept})


def _with_budget(run: Run, scenario: Scenario, resolved: Mapping[str, Any]) -> Run:
    seed = run.seed if run.seed is not None else secrets.randbelow(2**32)
    evaluations = run.evaluations
    if evaluations is None and "strategy" in resolved:
        strategy: Any = registry().find("strategy", resolved["strategy"]["use"])
        evaluations = strategy.evaluations_per_target * max(1, len(scenario.targets))
    return run.model_copy(update={"seed": seed, "evaluations": evaluations})


def _plain(model: Table) -> dict[str, Any]:
    """A model as TOML can hold it: no ``None``, no tuples."""
    dumped: dict[str, Any] = model.model_dump(mode="json", exclude_none=True)
    return dumped


def _where(layers: Sequence[_Layer], path: KeyPath) -> str:
    """Name the source that had the last word on a key; without a key, the file or document itself."""
    for layer in reversed(layers):
        if path and layer.holds(path):
            return layer.where(path)
    return next(layer for layer in reversed(layers) if not layer.is_option).where(path)


def _lines(
    error: ValidationError,
    prefix: KeyPath,
    model: type[Table],
    document: Mapping[str, Any],
    layers: Sequence[_Layer],
) -> list[str]:
    lines: list[str] = []
    wrong: dict[KeyPath, dict[str, str]] = {}
    items = error.errors(include_url=False)
    misspelt = {item["loc"][:-1] for item in items if item["type"] == "extra_forbidden"}
    for item in items:
        if item["type"] == "missing" and item["loc"][:-1] in misspelt:
            continue  # Most likely it is there under the other name: one line is enough.
        names = (*prefix, *item["loc"])
        # A key that may be of several types is reported once for each; the path then ends in the type's name.
        path = names
        while path and _value(document, path) is _NOTHING:
            path = path[:-1]
        if item["type"] == "extra_forbidden":
            siblings = _fields(model, path[len(prefix) : -1])
            table = _table(path[:-1])
            lines.append(
                f"{_where(layers, path)}: unknown key '{path[-1]}'{table}{did_you_mean(str(path[-1]), siblings)}"
            )
        elif item["type"] == "missing" and isinstance(names[-1], str):
            lines.append(f"{_where(layers, path)}: '{names[-1]}' is missing{_table(names[:-1])}")
        elif item["type"] == "value_error":
            message = str(item["ctx"]["error"])
            lines.append(f"{_where(layers, _blamed(message, path, document))}: {message}")
        else:
            wrong.setdefault(path, {})[item["type"]] = _should(item)
    for path, messages in wrong.items():
        key, value = _dotted(path), _value(document, path)
        lines.append(f"{_where(layers, path)}: {key} = {_shown(value)}: {', or '.join(messages.values())}")
    return lines


_SHOULD = {
    "float_type": "should be a number",
    "float_parsing": "should be a number",
    "int_type": "should be a whole number",
    "int_parsing": "should be a whole number",
    "int_from_float": "should be a whole number",
    "tuple_type": "should be a list",
    "dict_type": "should be a table",
    "model_type": "should be a table",
    "string_type": "should be text in quotes",
}
"""What a value should have been, for people who do not know Python's types, by pydantic's kind of error."""


def _should(item: Mapping[str, Any]) -> str:
    kind = item["type"]
    if kind == "missing":
        return f"should have {item['loc'][-1] + 1} values"
    if kind == "too_long":
        return f"should have at most {item['ctx']['max_length']} values"
    return _SHOULD.get(kind) or str(item["msg"]).replace("Input should be", "should be")


def _table(path: KeyPath) -> str:
    """`` in [table]``, as it stands in the file; empty at the top."""
    name = ".".join(str(part) for part in path if isinstance(part, str))
    if not name:
        return ""
    return f" in [[{name}]]" if isinstance(path[-1], int) else f" in [{name}]"


def _blamed(message: str, path: KeyPath, document: Mapping[str, Any]) -> KeyPath:
    """The key that a check of several keys speaks of: its message begins with it, or has it in quotes."""
    first = message.split(maxsplit=1)[0] if message else ""
    quoted = re.findall(r"'(.*?)'", message)
    for candidate in (tuple(first.split(".")), ("targets", first), *((*path, name) for name in quoted)):
        if _value(document, candidate) is not _NOTHING:
            return candidate
    return path


def _shown(value: Any) -> str:
    """A value as a TOML file has it, as far as Python's notation differs."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _fields(model: type[Table], path: KeyPath) -> list[str]:
    for name in path:
        if isinstance(name, int):
            continue
        annotation = model.model_fields[name].annotation if name in model.model_fields else None
        candidates = [annotation, *getattr(annotation, "__args__", ())]
        inner = [c for c in candidates if isinstance(c, type) and issubclass(c, Table)]
        if not inner:
            return []
        model = inner[0]
    return list(model.model_fields)
