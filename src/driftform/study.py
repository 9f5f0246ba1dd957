"""What to evolve: a TOML document -> scenario, plugins with their options, seed and budget; all checked.

A study file holds the scenario's tables (``[pipe]``, ``[flow]``, ``[targets]`` ...), a table for each seam
(``[simulator] use = "exudyn"``, the rest being that plugin's options) and ``[run]``. With ``base`` it starts from
another file, or from a built-in scenario, and says only what differs. Built-in scenarios are study files.
"""

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
from driftform.interfaces import SEAMS, SearchSpace, Strategy
from driftform.options import Table, option
from driftform.pipeline import Pipeline
from driftform.registry import registry
from driftform.scenario import Scenario
from driftform.toml_lines import key_lines, line_of

DEFAULT = "pipe-inspection"

SELECTED = tuple(seam for seam in SEAMS if seam != "exporter")
"""The seams that a study selects one plugin for."""

REPLACED = ("targets",)
"""Tables that a study file states anew instead of adding to those of its base."""


class Run(Table):
    """How much to do, from where, and what to make of the best."""

    seed: int | None = option(None, "seed of all randomness; drawn and recorded where none is given", ge=0)
    evaluations: int | None = option(
        None, "flights in the whole run; by default the strategy's, for each target", "", gt=0
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
    lines: Mapping[tuple[str, ...], int] = field(default_factory=dict)

    def holds(self, path: Sequence[str]) -> bool:
        node: Any = self.data
        for name in path:
            if not isinstance(node, Mapping) or name not in node:
                return False
            node = node[name]
        return True

    def where(self, path: tuple[str, ...]) -> str:
        line = line_of(path, dict(self.lines))
        return f"{self.label}:{line}" if line else self.label


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
        layers = _file_layers(source or DEFAULT, ())
    for seam, name in (use or {}).items():
        if name is not None:
            layers.append(_Layer(f"--{seam}", {seam: {"use": name}}))
    layers.extend(_setting(text) for text in settings)
    for key, value in (run or {}).items():
        if value is not None:
            layers.append(_Layer(f"--{key}", {"run": {key: value}}))
    document: dict[str, Any] = {}
    for layer in layers:
        document = _merged(document, layer.data)
    # A document may come from an agent file: what is there to fly needs no strategy.
    required = [seam for seam in SELECTED if seam != "strategy" or not isinstance(source, Document)]
    return _checked(document, layers, targets, required)


def _file_layers(source: str, above: tuple[str, ...]) -> list[_Layer]:
    builtins = builtin_scenarios()
    path = Path(source)
    if source in builtins and not path.is_file():
        label, text = f"{source} (built in)", builtins[source]
    elif path.is_file():
        label, text = str(path), _read(path)
    else:
        hint = did_you_mean(source, builtins) if path.suffix != ".toml" else ""
        raise InputError(f"study '{source}' is neither a file nor a built-in scenario{hint}")
    if label in above:
        raise InputError(f"{label}: 'base' leads back to the same file")
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{label}: is not valid TOML: {error}") from None
    layer = _Layer(label, data, key_lines(text))
    base = data.get("base")
    if base is None:
        return [layer]
    if not isinstance(base, str):
        raise InputError(f"{layer.where(('base',))}: base = {base!r} is not the name of a scenario or file")
    beside = path.parent / base
    return [*_file_layers(str(beside) if beside.is_file() else base, (*above, label)), layer]


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
    except tomllib.TOMLDecodeError:
        parsed = value.strip()
    for name in reversed(names):
        parsed = {name: parsed}
    return _Layer(f"--set {text}", parsed)


def _merged(below: Mapping[str, Any], above: Mapping[str, Any], path: tuple[str, ...] = ()) -> dict[str, Any]:
    result = dict(below)
    for key, value in above.items():
        old = result.get(key)
        both = isinstance(old, Mapping) and isinstance(value, Mapping)
        other_plugin = both and "use" in value and value["use"] != old.get("use")  # type: ignore[union-attr]
        if both and not other_plugin and not (not path and key in REPLACED):
            result[key] = _merged(old, value, (*path, key))  # type: ignore[arg-type]
        else:
            result[key] = value
    return result


def _checked(
    document: Mapping[str, Any], layers: Sequence[_Layer], wanted: Sequence[str], required: Sequence[str]
) -> Study:
    known = {"title", "description", "base", "run", *Scenario.model_fields, *SELECTED}
    errors = [
        f"{_where(layers, (key,))}: unknown key '{key}'{did_you_mean(key, known)}"
        for key in document
        if key not in known
    ]
    for key in known - {"title", "description", "base"}:
        if key in document and not isinstance(document[key], Mapping):
            errors.append(f"{_where(layers, (key,))}: {key} = {document[key]!r} is not a table")
    if errors:
        raise InputError("\n".join(errors))

    scenario: Scenario | None = None
    run: Run | None = None
    try:
        scenario = Scenario.model_validate({k: v for k, v in document.items() if k in Scenario.model_fields})
    except ValidationError as error:
        errors += _lines(error, (), Scenario, layers)
    try:
        run = Run.model_validate(document.get("run", {}))
    except ValidationError as error:
        errors += _lines(error, ("run",), Run, layers)
    resolved: dict[str, Any] = {}
    for seam in SELECTED:
        if seam not in required and seam not in document:
            continue
        try:
            resolved[seam] = _resolved_selection(document, seam, layers)
        except InputError as error:
            errors.append(str(error))
    if errors or scenario is None or run is None:
        raise InputError("\n".join(errors))
    scenario = _with_targets(scenario, wanted)
    run = _with_budget(run, scenario, resolved)
    for name in run.formats:
        registry().find("exporter", name)
    head = {key: document[key] for key in ("title", "description") if key in document}
    resolved = {**head, **_plain(scenario), **resolved, "run": _plain(run)}
    return Study(resolved, scenario, run)


def _resolved_selection(document: Mapping[str, Any], seam: str, layers: Sequence[_Layer]) -> dict[str, Any]:
    if seam not in document or "use" not in document[seam]:
        raise InputError(
            f"{layers[-1].label if seam not in document else _where(layers, (seam,))}: [{seam}] does not say which "
            f'plugin to use: add use = "...", or start from a built-in scenario with base = "{DEFAULT}"'
        )
    name, options = _selection(document, seam)
    try:
        cls = registry().find(seam, name)
    except InputError as error:
        raise InputError(f"{_where(layers, (seam, 'use'))}: {error}") from None
    try:
        checked = cls.Options.model_validate(options)
    except ValidationError as error:
        raise InputError("\n".join(_lines(error, (seam,), cls.Options, layers))) from None
    return {"use": name, **_plain(checked)}


def _selection(document: Mapping[str, Any], seam: str) -> tuple[str, dict[str, Any]]:
    options = dict(document[seam])
    return str(options.pop("use")), options


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


def _where(layers: Sequence[_Layer], path: tuple[str, ...]) -> str:
    for layer in reversed(layers):
        if layer.holds(path):
            return layer.where(path)
    return layers[-1].where(path)


def _lines(
    error: ValidationError, prefix: tuple[str, ...], model: type[Table], layers: Sequence[_Layer]
) -> list[str]:
    lines: list[str] = []
    for item in error.errors(include_url=False):
        names = prefix + tuple(part for part in item["loc"] if isinstance(part, str))
        # A key that may be of several types is reported once for each; the path ends in the type's name.
        path = names
        while path and not any(layer.holds(path) for layer in layers):
            path = path[:-1]
        if item["type"] == "missing":
            path = names[:-1]
        where, key = _where(layers, path), ".".join(path)
        if item["type"] == "extra_forbidden":
            siblings = _fields(model, path[len(prefix) : -1])
            table = f" in [{'.'.join(path[:-1])}]" if path[:-1] else ""
            line = f"{where}: unknown key '{path[-1]}'{table}{did_you_mean(path[-1], siblings)}"
        elif item["type"] == "missing":
            line = f"{where}: {'.'.join(names)} is missing"
        elif item["type"] == "value_error":
            line = f"{where}: {item['ctx']['error']}"
        else:
            message = item["msg"].replace("Input should be", "should be")
            line = f"{where}: {key} = {item['input']!r}: {message}"
        if not any(key and f": {key} = " in old and f": {key} = " in line for old in lines):
            lines.append(line)
    return lines


def _fields(model: type[Table], path: Sequence[str]) -> list[str]:
    for name in path:
        annotation = model.model_fields[name].annotation if name in model.model_fields else None
        candidates = [annotation, *getattr(annotation, "__args__", ())]
        inner = [c for c in candidates if isinstance(c, type) and issubclass(c, Table)]
        if not inner:
            return []
        model = inner[0]
    return list(model.model_fields)
