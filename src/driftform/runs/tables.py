"""A run as tables for data frames: one of its evaluations, one of the samples of their flights; column by column.

Both have the column ``evaluation``, by which they are joined. SI units; frames as in :mod:`driftform.types`.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np
import numpy.typing as npt

from driftform.geometry import mass_properties
from driftform.interfaces import Grammar, PhenotypeBuilder
from driftform.runs.store import Record
from driftform.scenario import Fluid
from driftform.study import Study
from driftform.tables.columns import BODY_COLUMNS, FLIGHT_COLUMNS, Batch, Column, evaluation_columns
from driftform.types import Genome

ROWS = 4096
"""Most evaluations in a batch."""

SAMPLES = 200_000
"""A batch of samples is complete with the flight that reaches so many."""


def evaluation_batches(study: Study, records: Iterable[Record]) -> Iterator[Batch]:
    """Evaluations in batches of at most :data:`ROWS`; bodies are built anew from their genomes."""
    columns = evaluation_columns(study.scenario.target_names)
    describe = _describer(study)
    left = iter(records)
    while rows := [describe(record) for record in islice(left, ROWS)]:
        yield {column.name: [row[i] for row in rows] for i, column in enumerate(columns)}


def _describer(study: Study) -> Callable[[Record], tuple[Any, ...]]:
    grammar, builder, fluid = study.make_plugin("grammar"), study.make_plugin("builder"), study.scenario.fluid

    def describe(record: Record) -> tuple[Any, ...]:
        candidate, evaluation = record.candidate, record.evaluation
        flight = evaluation.trajectory
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
            evaluation.failure,
            *outcome,
            evaluation.seconds,
            record.seed,
            *_body_facts(grammar, builder, fluid, candidate.genome),
            *evaluation.fitness.tolist(),
        )

    return describe


def _body_facts(
    grammar: Grammar[Any], builder: PhenotypeBuilder[Any], fluid: Fluid, genome: Genome
) -> tuple[Any, ...]:
    try:
        morphology = grammar.express(genome)
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
    told = {
        name: {c.name: {"unit": c.unit, "meaning": c.meaning} for c in columns}
        for name, columns in tables.items()
    }
    return json.dumps({**facts, "tables": told}, indent=1) + "\n"
