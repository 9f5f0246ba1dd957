"""A run as tables for data frames: one of its evaluations, one of the samples of their flights; column by column.

Both have the column ``evaluation``, by which they are joined. SI units; frames as in :mod:`driftform.types`.
"""

import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from math import isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from driftform import __version__
from driftform.agent import mass_properties
from driftform.errors import InputError, did_you_mean
from driftform.interfaces import Grammar, PhenotypeBuilder
from driftform.runs.run import StoredRun
from driftform.runs.store import Record, Store
from driftform.runs.table_files import (
    BODY_COLUMNS,
    FLIGHT_COLUMNS,
    FORMATS,
    MEASURE_COLUMNS,
    SAMPLE_COLUMNS,
    Batch,
    Column,
    check_format,
    evaluation_columns,
)
from driftform.study import Study
from driftform.types import Genome
from driftform.util.files import check_new_directory, write_together
from driftform.util.progress import track_progress
from driftform.water import Fluid

FOLDER = "data"
"""The folder of a run that its tables are written to where no other is named."""

COLUMNS = "columns.json"
"""The file with unit and meaning of each column."""

CHUNK = 64
"""Evaluations that are read at a time: no writer has to wait for a reader, and logs stay short."""

MAX_ROWS = 4096
"""Evaluations in a batch."""

SAMPLES = 200_000
"""A batch of samples is complete with the flight that reaches so many."""


def write_tables(
    run: StoredRun, folder: Path | None = None, format: str = "csv", trajectories: bool = False
) -> dict[str, int]:
    """Write a run as tables for data frames, and return the number of rows of each.

    Args:
        run: finished or not; what is stored at the beginning is written.
        folder: for the files; ``None`` for ``data`` in the run, whose older tables are replaced.
        format: ``"csv"`` or ``"parquet"``, which needs pyarrow.
        trajectories: whether the samples of all flights are written too, hundreds for each.

    Raises:
        InputError: if the format is unknown, or the folder is not empty.
        WorkFailedError: if pyarrow is missing.
    """
    check_output(format, folder)
    target = folder or run.path / FOLDER
    older = {f"{table}.{suffix}" for table in ("evaluations", "trajectories") for suffix in FORMATS}
    with run.read(check=True) as store, write_together(target, older) as part:
        return _write(part, run.study, store, format, trajectories)


def check_output(format: str, folder: Path | None = None) -> None:
    """Refuse tables that cannot be written, before anything is read.

    Raises InputError if the format is unknown, or the folder is not empty. Raises WorkFailedError if pyarrow is missing.
    """
    if format not in FORMATS:
        raise InputError(f"--format {format}: unknown format of tables{did_you_mean(format, FORMATS)}")
    check_format(format)
    if folder is not None:
        check_new_directory(folder)


def _write(part: Path, study: Study, store: Store, format: str, trajectories: bool) -> dict[str, int]:
    """Write the tables and the meaning of their columns into a directory; return how many rows each has."""
    targets = study.scenario.target_names
    tables: dict[str, Sequence[Column]] = {"evaluations": list_columns(study, store)}
    write, rows = FORMATS[format], {}
    # What is stored from now on has no row in any table.
    stored = {brief.index for brief in store.read_summaries(())}
    records = track_progress(_read_in_chunks(store, targets, stored), len(stored), "evaluations")
    path = part / f"evaluations.{format}"
    rows["evaluations"] = write(path, tables["evaluations"], evaluation_batches(study, records, tables["evaluations"]))
    if trajectories:
        tables["trajectories"] = SAMPLE_COLUMNS
        records = track_progress(_read_in_chunks(store, targets, stored), len(stored), "flights")
        rows["trajectories"] = write(part / f"trajectories.{format}", SAMPLE_COLUMNS, sample_batches(records))
    facts = {"driftform": __version__, "seed": study.seed}
    (part / COLUMNS).write_text(describe_tables(tables, facts), encoding="utf-8")
    return rows


def _read_in_chunks(store: Store, targets: tuple[str, ...], indices: Collection[int]) -> Iterator[Record]:
    for first in range(0, max(indices, default=-1) + 1, CHUNK):
        yield from [record for record in store.read_records(targets, first, CHUNK) if record.index in indices]


def list_columns(study: Study, store: Store) -> tuple[Column, ...]:
    """Return the columns of the evaluations of a run, also of constraints that a plugin names where one is missed."""
    measures, constraints = study.make_plugin("fitness").measures, store.list_constraints()
    return evaluation_columns(study.scenario.target_names, measures, constraints)


def evaluation_batches(study: Study, records: Iterable[Record], columns: Sequence[Column]) -> Iterator[Batch]:
    """Evaluations in batches of at most :data:`MAX_ROWS`; bodies are built anew from their genomes."""
    names = [column.name for column in columns]
    describe = _describer(study, names[names.index(MEASURE_COLUMNS[0].name) : -len(study.scenario.targets)])
    left = iter(records)
    while rows := [describe(record) for record in islice(left, MAX_ROWS)]:
        yield {name: [row[i] for row in rows] for i, name in enumerate(names)}


def _describer(study: Study, names: Sequence[str]) -> Callable[[Record], tuple[Any, ...]]:
    grammar, builder, fluid = study.make_plugin("grammar"), study.make_plugin("builder"), study.scenario.fluid

    def describe(record: Record) -> tuple[Any, ...]:
        candidate, evaluation = record.candidate, record.evaluation
        flight, measured = evaluation.trajectory, {**evaluation.measures, **evaluation.violations}
        outcome: tuple[Any, ...] = (None,) * 5
        if flight is not None:
            trust = (flight.contact, flight.energy_drift, flight.error)
            outcome = (str(flight.end), float(flight.t[-1]), *trust)
        return (
            record.index,
            candidate.generation,
            candidate.target,
            list(candidate.parents),
            grammar.to_text(candidate.genome),
            candidate.genome.tuning,
            evaluation.failure,
            *outcome,
            evaluation.seconds,
            record.seed,
            *_body_facts(grammar, builder, fluid, candidate.genome),
            *(None if isnan(measured.get(name, nan)) else measured[name] for name in names),
            *evaluation.fitness.tolist(),
        )

    return describe


def _body_facts(grammar: Grammar[Any], builder: PhenotypeBuilder[Any], fluid: Fluid, genome: Genome) -> tuple[Any, ...]:
    try:
        morphology = replace(grammar.express(genome), tuning=genome.tuning)
        body = builder.build(morphology)
        mass = mass_properties(body)
    except Exception:
        # A genome without a body is a failure of the run, recorded with its reason, and none of its table.
        return (None,) * len(BODY_COLUMNS)
    net_buoyancy = mass.net_buoyancy(fluid)
    return (len(morphology.modules), body.length, body.max_diameter, mass.mass, mass.volume, net_buoyancy)


def sample_batches(records: Iterable[Record]) -> Iterator[Batch]:
    """Samples of all flights, in batches of whole flights; what an evaluation without a flight has is nothing."""
    waiting: list[tuple[int, npt.NDArray[np.float32]]] = []
    count = 0
    for record in records:
        flight = record.evaluation.trajectory
        if flight is None:
            continue
        parts = (flight.t, flight.position, flight.quaternion, flight.velocity)
        waiting.append((record.index, np.column_stack(parts).astype(np.float32)))
        count += len(flight.t)
        if count >= SAMPLES:
            yield _join(waiting)
            waiting, count = [], 0
    if waiting:
        yield _join(waiting)


def _join(flights: Sequence[tuple[int, npt.NDArray[np.float32]]]) -> Batch:
    whose = np.repeat([index for index, _ in flights], [len(samples) for _, samples in flights])
    samples = np.concatenate([samples for _, samples in flights])
    return {"evaluation": whose, **dict(zip(FLIGHT_COLUMNS, samples.T, strict=True))}


def describe_tables(tables: Mapping[str, Sequence[Column]], facts: Mapping[str, Any]) -> str:
    """What the columns of some tables mean, with ``facts`` of where they come from, as JSON."""
    columns = {
        name: {c.name: {"unit": c.unit, "meaning": c.meaning} for c in columns} for name, columns in tables.items()
    }
    return json.dumps({**facts, "tables": columns}, indent=1) + "\n"
