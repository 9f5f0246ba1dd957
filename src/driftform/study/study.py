"""A study: a TOML document -> scenario, plugins with their options, seed and budget; all checked.

A study file holds the scenario's tables (``[pipe]``, ``[flow]``, ``[targets]`` ...), a table for each seam
(``[simulator] use = "exudyn"`` and the options of that plugin), one for each exporter, recorder, renderer or checker
whose options differ from their defaults (``[exporter.stl]``), and ``[run]``. A study with a ``base``, another file or
a built-in scenario, contains only what differs from it. Built-in scenarios are study files.
"""

import logging
import reprlib
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from pydantic import ValidationError

from driftform.errors import DriftformError, InputError, did_you_mean
from driftform.interfaces import (
    NAMED,
    SEAMS,
    WITHIN,
    Begin,
    Checker,
    Exporter,
    Grammar,
    PrintJob,
    Recorder,
    Renderer,
    SearchSpace,
    Strategy,
)
from driftform.pipeline import Pipeline
from driftform.plugins.faults import describe_fault
from driftform.plugins.registry import Contribution, registry
from driftform.plugins.seams import check_grammar, check_wording, require_findings
from driftform.study.error_lines import format_errors
from driftform.study.sources import (
    Source,
    join_path,
    locate_key,
    merge_source,
    parse_setting,
    read_calibration,
    read_scenarios,
    read_sources,
)
from driftform.study.toml_positions import find_key_lines
from driftform.types import ByContent, Finding, Genome, State
from driftform.util.options import MAX_SEED, Table, option
from driftform.water import Scenario
from driftform.water.flow import GridFlow

_log = logging.getLogger(__name__)

DEFAULT = "pipe-inspection"
"""The default scenario."""

ROBUST = {"robust": "conditions", "within": "within"}
"""The keys of ``[robustness]`` that have a short name beside those of ``[run]``."""

NOT_FLOWN = ("strategy", "run")
"""The tables that do not decide how an agent is built and flies."""

FORMER = ("inspector", "reporter")
"""The tables that runs of 0.2.0 hold without content, of seams that there were then."""

SELECTED = tuple(seam for seam in SEAMS if seam not in (*NAMED, *WITHIN))
"""The seams for which a study selects one plugin."""

MAX_EVALUATIONS = 10_000_000
"""Largest budget of a run: weeks of flights, and a database of 100 GB."""

DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{number}" for port in ("com", "lpt") for number in range(1, 10))}
"""Names of devices, which Windows does not allow for files."""

_MAX_NAME_BYTES = 100
"""Longest name of a target, bytes: with a file suffix it must fit into a file name of 255 bytes."""


class RunOptions(Table):
    """The table ``[run]``: seed, budget, time limit, and files for the best agents."""

    seed: int | None = option(
        None, "seed of all randomness; by default drawn at random and recorded", ge=0, le=MAX_SEED, strict=True
    )
    evaluations: int | None = option(
        None, "evaluations in the whole run; by default 50 for each target", "", gt=0, le=MAX_EVALUATIONS, strict=True
    )
    evaluation_timeout: float = option(
        60.0, "processor time after which an evaluation has failed; waiting counts a tenth", "s", gt=0, le=86400
    )
    formats: tuple[str, ...] = option(("stl",), "formats to export for the best agent of each target")


@dataclass(frozen=True, eq=False)
class Study(ByContent):
    """A checked study.

    Attributes:
        document: the whole document with every default filled in, as in ``resolved.toml`` and for worker processes.
        scenario: the environment.
        run: seed (never ``None``), budget (``None`` only without a strategy) and formats.
        name: the file, built-in scenario or document that it was loaded from.
        given: the text of that file; empty for a document.
    """

    document: Mapping[str, Any]
    scenario: Scenario
    run: RunOptions
    name: str = ""
    given: str = ""

    @property
    def title(self) -> str:
        """The title that its file gives it, or nothing."""
        return str(self.document.get("title", ""))

    @property
    def seed(self) -> int:
        """The seed of all randomness."""
        assert self.run.seed is not None
        return self.run.seed

    @property
    def evaluations(self) -> int:
        """Budget of the whole run, evaluations."""
        assert self.run.evaluations is not None
        return self.run.evaluations

    def make_plugin(self, seam: str) -> Any:
        """Create the plugin selected for a seam, except ``strategy``, which needs a search space."""
        return registry().create(seam, *_split_selection(self.document, seam))

    def make_pipeline(self) -> Pipeline:
        """Create the pipeline from genome to fitness."""
        steps = {seam: self.make_plugin(seam) for seam in SELECTED if seam != "strategy"}
        check_grammar(steps["grammar"])
        check_wording(steps["fitness"])
        return Pipeline(scenario=self.scenario, **steps)

    def make_strategy(self, begin: Begin | None = None) -> Strategy[Any]:
        """Create a strategy in its initial state, with a random generator from the seed, and what ``begin`` calls for it."""
        rng = np.random.default_rng(self.seed)
        grammar, builder = self.make_plugin("grammar"), self.make_plugin("builder")
        space = SearchSpace(grammar, self.scenario.target_names, rng, self.scenario, builder, begin)
        made = registry().create("strategy", *_split_selection(self.document, "strategy"), space=space)
        return cast("Strategy[Any]", made)

    def check_formats(self) -> None:
        """Check that the formats of a run's files can be written, as :func:`load_study` does for files.

        Raises:
            InputError: if there is no exporter for one.
        """
        _check_formats(self.run.formats, [Source(self.name, self.document)])

    def check_search(self) -> None:
        """Refuse a study that cannot be searched, before anything is written.

        Raises:
            InputError: if it has no targets, with the line to add, if its grammar has nothing to vary, or if its strategy
                does not accept it.
        """
        if not self.scenario.targets:
            raise InputError(f"{self.name}: has no [targets]; add at least one, such as leak = [4.0, 0.0, -0.9]")
        grammar: Grammar[Any] = self.make_plugin("grammar")
        genome = None
        with suppress(Exception):
            # A grammar that fails is named where it is tried, before the search.
            genome = grammar.random(np.random.default_rng(0))
        if isinstance(genome, Genome) and not genome.symbols:
            raise InputError(
                f"{self.name}: grammar '{grammar.name}' has one genome, without symbols: nothing can evolve; choose another"
            )
        self.make_strategy()

    def list_warnings(self) -> list[str]:
        """Return what is likely to be wrong with it, one line each; nothing flies.

        Raises:
            InputError: if not even the smallest body of the builder can be released.
        """
        from driftform.study.advice import list_warnings

        return list_warnings(self.name, self.make_pipeline())

    @staticmethod
    def list_scenarios() -> Mapping[str, str]:
        """Return the text of each built-in scenario, by the name that :func:`load_study` takes."""
        return read_scenarios()

    @staticmethod
    def find_lines(text: str) -> dict[str, int]:
        """Return the line of each key in the text of a study file, such as ``{"pipe.segments[0].radius": 4}``."""
        return {join_path(path): line for path, line in find_key_lines(text).items()}

    def make_exporter(self, name: str) -> Exporter[Any]:
        """Create an exporter with the options of its table ``[exporter.<name>]``, if there is one."""
        return cast("Exporter[Any]", self._make_named("exporter", name))

    def make_recorder(self, name: str) -> Recorder[Any]:
        """Create a recorder with the options of its table ``[recorder.<name>]``, if there is one."""
        return cast("Recorder[Any]", self._make_named("recorder", name))

    def make_renderer(self, name: str) -> Renderer[Any]:
        """Create a renderer with the options of its table ``[renderer.<name>]``, if there is one."""
        return cast("Renderer[Any]", self._make_named("renderer", name))

    def check_print(self, name: str, job: PrintJob) -> Iterator[Finding]:
        """Yield what a checker finds; one that fails, and not for a reason that it explains, gives a skipped finding.

        Raises:
            DriftformError: if the checker cannot read a file, or returns something else than findings.
        """
        checker: Checker[Any] = self._make_named("checker", name)
        try:
            yield from require_findings(checker.check(job), checker)
        except DriftformError:
            raise
        except (Exception, SystemExit) as error:
            # One checker that fails is no reason to keep back what the others find.
            yield Finding(name, State.SKIPPED, describe_fault(error))

    @staticmethod
    def list_plugins(seam: str) -> list[Contribution]:
        """Return what is installed for a seam such as ``checker``, by name: its class, or why that is unavailable."""
        return registry().seam(seam)

    def __repr__(self) -> str:
        # The document would fill a screen.
        title = self.document.get("title", "a study")
        return f"<Study {title}: {len(self.scenario.targets)} targets, seed {self.seed}>"

    def _repr_html_(self) -> str:
        from driftform.util.notebook import show_table

        plugins = [(seam, self.document[seam]["use"]) for seam in SELECTED if seam in self.document]
        targets = [(name, *(f"{c:g}" for c in point)) for name, point in self.scenario.target_points().items()]
        return show_table(("step", "plugin"), plugins, repr(self)[1:-1]) + show_table(
            ("target", "x m", "y m", "z m"), targets
        )

    def _make_named(self, seam: str, name: str) -> Any:
        return registry().create(seam, name, self.document.get(seam, {}).get(name, {}))

    def environment(self, evaluation: int | None = None) -> dict[str, Any]:
        """Return the part of the document that decides how an agent is built and flies: all but strategy and run.

        With the index of an ``evaluation``, the gusts are those of that evaluation.
        """
        kept = {key: value for key, value in self.document.items() if key not in NOT_FLOWN}
        if evaluation is not None:
            kept["gusts"] = _to_plain(self.scenario.of_evaluation(self.seed, evaluation).gusts)
        return kept


@dataclass(frozen=True, eq=False)
class Document:
    """The document of a study, ``data``, that was not read from a TOML file; ``label`` is its name in errors."""

    label: str
    data: Mapping[str, Any]


def load_study(
    source: "str | Document | None" = None,
    settings: Sequence[str] = (),
    *,
    targets: Sequence[str] = (),
    use: Mapping[str, str | None] | None = None,
    run: Mapping[str, Any] | None = None,
    calibration: str | None = None,
) -> Study:
    """Read, merge and check a study.

    Args:
        source: path of a TOML file, name of a built-in scenario, or document of an agent or run file; ``None`` for
            the default scenario.
        settings: ``key=value`` with a dotted key and a TOML value, which override the file.
        targets: targets to keep; empty for all.
        use: plugin by seam, if not ``None``.
        run: values of ``[run]``, if not ``None``; and as options of ``driftform evolve``, ``robust`` (number of disturbed
            conditions) and ``within`` (m).
        calibration: path of a file with the table ``[calibration]``, which replaces that of the study.

    Raises:
        InputError: if the study is wrong: one line for each error, with file, line, key, value and the next step.
    """
    if isinstance(source, Document):
        label = source.label
        layers = [Source(label, source.data)]
    else:
        label = DEFAULT if source is None else source
        layers = read_sources(label)
    _log.debug("study %s from %s", label, ", ".join(layer.label for layer in layers))
    given = layers[-1].text
    if calibration is not None:
        layers.append(read_calibration(calibration))
    for seam, name in (use or {}).items():
        if name is not None:
            layers.append(Source(f"--{seam}", {seam: {"use": name}}, is_option=True))
    layers.extend(parse_setting(text) for text in settings)
    for key, value in (run or {}).items():
        if value is not None:
            table, name = ("robustness", ROBUST[key]) if key in ROBUST else ("run", key)
            layers.append(Source(f"--{key}", {table: {name: value}}, is_option=True))
    document: dict[str, Any] = {}
    for layer in layers:
        document = merge_source(document, layer)
    document = {key: value for key, value in document.items() if value or key not in FORMER}
    # A document may come from an agent file, which needs no strategy to fly; commands that write files check their formats.
    is_file = not isinstance(source, Document)
    required = [seam for seam in SELECTED if seam != "strategy" or is_file]
    study = _check_document(document, layers, targets, required)
    if is_file:
        _check_formats(study.run.formats, layers)
        _check_grid(study.scenario, layers)
    return replace(study, name=label, given=given)


def _check_document(
    document: Mapping[str, Any], layers: Sequence[Source], wanted: Sequence[str], required: Sequence[str]
) -> Study:
    known = {"title", "description", "base", "run", *Scenario.model_fields, *SELECTED, *NAMED}
    errors = [
        f"{locate_key(layers, (key,))}: unknown key '{key}'{did_you_mean(key, known)}"
        for key in document
        if key not in known
    ]
    for key in known - {"title", "description", "base"}:
        if key in document and not isinstance(document[key], Mapping):
            errors.append(f"{locate_key(layers, (key,))}: {_describe_no_table(key, document[key])}")
    for key in ("title", "description"):
        if not isinstance(document.get(key, ""), str):
            errors.append(f"{locate_key(layers, (key,))}: {key} = {document[key]!r}: should be text in quotes")
    if errors:
        raise InputError(*errors)

    scenario: Scenario | None = None
    run: RunOptions | None = None
    try:
        scenario = Scenario.model_validate({k: v for k, v in document.items() if k in Scenario.model_fields})
    except ValidationError as error:
        errors += format_errors(error, (), Scenario, document, layers)
    try:
        run = RunOptions.model_validate(document.get("run", {}))
    except ValidationError as error:
        errors += format_errors(error, ("run",), RunOptions, document, layers)
    registry().check_seams(SELECTED)
    resolved: dict[str, Any] = {}
    # An agent has no strategy; one of which only options are given has no name.
    asked = [seam for seam in SELECTED if seam in required or seam in document]
    unselected = [seam for seam in asked if "use" not in document.get(seam, {})]
    if unselected:
        tables = ", ".join(f"[{seam}]" for seam in unselected)
        where = locate_key(layers, (unselected[0],) if len(unselected) == 1 else ())
        errors.append(
            f'{where}: no plugin is selected in {tables}; add a line such as use = "..." '
            f"(see 'driftform plugins'), or begin the study with base = \"{DEFAULT}\""
        )
    for seam in SELECTED:
        if seam in unselected or seam not in document:
            continue
        try:
            name, options = _split_selection(document, seam)
            resolved[seam] = {"use": name, **_resolve_options(document, (seam,), name, options, layers, {})}
        except InputError as error:
            errors.extend(error.args)
    kit = resolved.get("builder", {}).get("kit")
    simulated = {"exporter": kit if isinstance(kit, dict) else {}}
    named: dict[str, dict[str, Any]] = {seam: {} for seam in NAMED}
    for seam in NAMED:
        for name, options in document.get(seam, {}).items():
            try:
                found = _resolve_options(document, (seam, name), name, options, layers, simulated.get(seam, {}))
                named[seam][name] = found
            except InputError as error:
                errors.extend(error.args)
    if errors or scenario is None or run is None:
        raise InputError(*errors)
    _check_folders(scenario, layers, is_new="strategy" in required)
    scenario = _keep_targets(scenario, wanted)
    run = _fill_budget(run, scenario, resolved)
    head = {key: document[key] for key in ("title", "description") if key in document}
    resolved = {**head, **_to_plain(scenario), **resolved, **named, "run": _to_plain(run)}
    return Study(resolved, scenario, run)


def _check_formats(formats: Sequence[str], layers: Sequence[Source]) -> None:
    for index, name in enumerate(formats):
        try:
            registry().find("exporter", name)
        except InputError as error:
            raise InputError(f"{locate_key(layers, ('run', 'formats', index))}: {error}") from None


def _check_grid(scenario: Scenario, layers: Sequence[Source]) -> None:
    """Read the file of a grid, before anything rests on it."""
    if not isinstance(scenario.flow, GridFlow):
        return
    from driftform.water.fittings import fitting_array

    try:
        fitting_array(scenario)
    except ValueError as error:
        raise InputError(f"{locate_key(layers, ('flow', 'file'))}: {error}") from None


def _describe_no_table(key: str, value: object) -> str:
    if key == "targets" and isinstance(value, list):
        return "targets is a list of tables; write one table [targets] with a line NAME = [x, y, z] for each"
    if isinstance(value, list) and len(value) == 1:
        return f"{key} is a list of tables; write [{key}] instead of [[{key}]]"
    return f"{key} = {reprlib.repr(value)} is not a table"


def _resolve_options(
    document: Mapping[str, Any],
    path: tuple[str, ...],
    name: str,
    options: Any,
    layers: Sequence[Source],
    others: Mapping[str, Any],
) -> dict[str, Any]:
    """Validate the options of the plugin ``name`` in the table ``path``, whose first part is the seam.

    Those that are not given are ``others``, such as those of the kit that is weighed, where it has them.
    """
    try:
        cls = registry().find(path[0], name)
    except InputError as error:
        key = (*path, "use") if path[0] in SELECTED else path
        raise InputError(f"{locate_key(layers, key)}: {error}") from None
    if not isinstance(options, Mapping):
        raise InputError(f"{locate_key(layers, path)}: {'.'.join(path)} = {options!r} is not a table")
    options = {key: value for key, value in others.items() if key in cls.Options.model_fields} | dict(options)
    try:
        checked = registry().check_options(path[0], name, options)
    except ValidationError as error:
        raise InputError(*format_errors(error, path, cls.Options, document, layers)) from None
    return _to_plain(checked)


def _split_selection(document: Mapping[str, Any], seam: str) -> tuple[str, dict[str, Any]]:
    options = dict(document[seam])
    return str(options.pop("use")), options


def _check_folders(scenario: Scenario, layers: Sequence[Source], is_new: bool) -> None:
    """Check that names of targets are short enough for folders, and differ on all file systems.

    New ones are no options of a command, and no devices of Windows, in place of folders.
    """
    seen: dict[str, str] = {}
    for name in scenario.targets:
        where = locate_key(layers, ("targets", name))
        if len(name.encode()) > _MAX_NAME_BYTES:
            raise InputError(
                f"{where}: target name '{name[:20]}...' is longer than {_MAX_NAME_BYTES} bytes: it names a folder"
            )
        if name.casefold() in seen:
            raise InputError(
                f"{where}: target names '{seen[name.casefold()]}' and '{name}' differ only in case: "
                "on some file systems their folders would be the same"
            )
        seen[name.casefold()] = name
        if is_new and (name.startswith("-") or name.casefold() in DEVICES):
            raise InputError(f"{where}: target name '{name}' is no name of a folder everywhere; choose another")


def _keep_targets(scenario: Scenario, wanted: Sequence[str]) -> Scenario:
    for name in wanted:
        if name not in scenario.targets:
            raise InputError(f"--target {name}: unknown target{did_you_mean(name, scenario.targets)}")
    if not wanted:
        return scenario
    kept = {name: point for name, point in scenario.targets.items() if name in wanted}
    return scenario.model_copy(update={"targets": kept})


def _fill_budget(run: RunOptions, scenario: Scenario, resolved: Mapping[str, Any]) -> RunOptions:
    seed = run.seed if run.seed is not None else secrets.randbelow(2**32)
    evaluations = run.evaluations
    if evaluations is None and "strategy" in resolved:
        strategy: Any = registry().find("strategy", resolved["strategy"]["use"])
        evaluations = strategy.evaluations_per_target * max(1, len(scenario.targets))
    return run.model_copy(update={"seed": seed, "evaluations": evaluations})


def _to_plain(model: Table) -> dict[str, Any]:
    """Return the values of a model in types of TOML: no ``None``, no tuples."""
    dumped: dict[str, Any] = model.model_dump(mode="json", exclude_none=True)
    return dumped
