"""An agent as the page shows it, and the files that can be taken of it."""

import json
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

from driftform import Design, Run, StoredAgent
from driftform.agent import hull_mass
from driftform.cli import formats
from driftform.design.limits import list_limits
from driftform.errors import InputError, did_you_mean
from driftform.figures.style import SERIES
from driftform.motion import closest_approach
from driftform.report.viewer import agent_data
from driftform.runs.agent_file import agent_document
from driftform.runs.coverage import PipeGrid, UnrolledGrid, map_coverage
from driftform.runs.dependence import divide_spread
from driftform.runs.misses import Misses, finite_or_none
from driftform.search.finalists import find_winner
from driftform.search.picking import write_pick
from driftform.types import BoolArray, FloatArray, Trajectory
from driftform.util.progress import count_progress, track_progress

FORMATS = {"stl": ("stl", False), "3mf": ("3mf", False), "kit": ("3mf", True)}
"""What can be taken for a printer: the exporter of each, and whether it writes a kit."""


def describe_agent(run: Run, key: str, stored: StoredAgent) -> dict[str, Any]:
    """Return what the page shows of an agent: its body, its flight, its facts, and what is promised of it."""
    design = Design.build(stored, f"{run.name}: {key}")
    flight = _read_flight(run, design)
    scenario, agent, result = run.study.scenario, design.agent, stored.result
    is_best = key in scenario.targets
    point = scenario.target_points()[key] if is_best else tuple(result["point"])
    [distance], [t] = closest_approach(flight, np.array([point], dtype=np.float64))
    colour = SERIES[list(scenario.targets).index(key) % len(SERIES)] if is_best else SERIES[-1]
    names = list(scenario.targets)
    misses = _read_misses(run, key) if is_best else None
    return {
        "key": key,
        "target": key if is_best else None,
        "point": list(point),
        "evaluation": result["evaluation"],
        **agent_data(agent, flight, [float(t)], colour),
        "longest": round(agent.body.length, 4),
        "end": str(flight.end),
        "promise": {"nominal": float(distance), **_summarise(misses, 0)},
        "effects": _list_effects(misses, 0),
        "limits": list_limits(agent, scenario),
        "facts": {
            "length": design.length,
            "diameter": design.max_diameter,
            "mass": design.mass.mass,
            "hull": hull_mass(agent.body),
            "buoyancy": design.net_buoyancy,
            "modules": len(agent.morphology.modules) if agent.morphology else 0,
        },
        "number": names.index(key) if is_best else len(names),
    }


def disturb_agent(run: Run, key: str, stored: StoredAgent) -> dict[str, Any]:
    """Fly an agent under disturbed conditions, and return what is promised of it."""
    design = Design.build(stored, f"{run.name}: {key}")
    scenario = design.scenario
    if key not in scenario.targets:
        # The point that was picked takes the place of the targets.
        point = json.dumps(list(stored.result["point"]))
        design = design.under(f"targets={{picked = {point}}}")
    flights = scenario.robustness.checks
    number = list(scenario.targets).index(key) if key in scenario.targets else 0
    with count_progress("disturbed flights") as show:
        misses = design.disturb(flights, progress=show)
    return {"promise": _summarise(misses, number), "effects": _list_effects(misses, number)}


def draw_section(stored: StoredAgent, key: str) -> str:
    """Return the half section of an agent as SVG."""
    return Design.build(stored, key)._repr_svg_()


def write_agent_text(stored: StoredAgent) -> str:
    """Return the text of an ``agent.json``."""
    return json.dumps(agent_document(stored), indent=1) + "\n"


def export_agent(stored: StoredAgent, kind: str, folder: Path) -> Path:
    """Write an agent for a printer into a folder, and return the file: an archive, if there are several.

    Raises
    ------
    InputError
        if there is no such kind.
    WorkFailedError
        if the agent cannot be written so.
    """
    if kind not in FORMATS:
        raise InputError(f"there are no files '{kind}'{did_you_mean(kind, FORMATS)}")
    format, kit = FORMATS[kind]
    settings = formats.list_exporter_settings((format,), {"kit": ("true", "a kit")} if kit else {})
    design = Design.build(stored, stored.name, settings=settings)
    path = folder / f"{design.name}{design.study.make_exporter(format).suffix}"
    written = [Path(file.path) for file in design.export_files(format, path)]
    if len(set(written)) == 1:
        return written[0]
    archive = folder / f"{design.name}-{kind}.zip"
    with ZipFile(archive, "w", ZIP_DEFLATED) as packed:
        for file in sorted(set(written)):
            packed.write(file, file.relative_to(folder))
    return archive


def map_reach(run: Run) -> dict[str, Any]:
    """Return the reach map: the class of each cell by the closest flight, and where the cells lie in the pipe.

    A cell that no flight crosses has the class -1, and one that is not in the pipe -2: beside a narrow bore, or between
    the parts on an unrolled map. ``edges`` has two edges for each column of cells, upstream and downstream, from the lowest to
    the highest point of the map; ``None`` for a column that is not in the pipe.

    Raises
    ------
    InputError
        if the run is in open water.
    """
    from driftform.figures.reach import BOUNDS, RAMP

    cells = PipeGrid.of_scenario(run.study.scenario)
    with run.read() as store:
        flights = track_progress(store.read_trajectories(), store.count_sound(), "flights", delay=0.3)
        reach = map_coverage(flights, cells)
    classes = np.searchsorted(BOUNDS, reach.distance, side="right")
    classes[~reach.reached] = -1
    edges = _place_columns(cells)
    placed: BoolArray = np.asarray(np.isfinite(edges).all(axis=(1, 2, 3)))
    classes[~reach.reached & ~_find_real(cells)] = -2
    classes.reshape(cells.shape)[~placed] = -2
    return {
        "edges": [np.round(e, 4).tolist() if there else None for e, there in zip(edges, placed, strict=True)],
        "columns": cells.shape[0],
        "rows": cells.shape[1],
        "classes": classes.tolist(),
        "colours": list(RAMP),
        "bounds": list(BOUNDS),
        "flights": reach.flights,
        "reached": int(reach.reached.sum()),
        "cells": int((classes > -2).sum()),
    }


def _place_columns(cells: PipeGrid) -> FloatArray:
    """Return both edges of each column of a map from bottom to top in the world frame, m, (columns, 2, 2, 3)."""
    columns, rows = cells.shape
    width, top = cells.size[0], 0.5 * rows * cells.size[1]
    # Just within the column: the end of a branch's axis is not the beginning of the gap behind it.
    inset = 1e-6 * width
    x = width * np.arange(columns)[:, None] + np.array([inset, width - inset])
    corners = np.stack(np.broadcast_arrays(x[:, :, None], np.array([-top, top])), axis=-1)
    return cells.to_world(corners.reshape(-1, 2)).reshape(columns, 2, 2, 3)


def _find_real(cells: PipeGrid) -> BoolArray:
    """Return which cells of a map have their centre in the pipe at the place that the map says, (cells,)."""
    centres = cells.centres()
    world = cells.to_world(centres)
    real: BoolArray = np.asarray(np.isfinite(world).all(axis=1))
    if isinstance(cells, UnrolledGrid):
        real[real] = cells.layout.find_part(world[real]) >= 0
    # Where a branch leaves, the map of the run and that of the branch overlap: each point is on one of them.
    real[real] = np.abs(cells.to_map(world[real])[:, :2] - centres[real]).max(axis=1) < 1e-6
    return real


def pick(run: Run, point: tuple[float, float, float]) -> dict[str, Any]:
    """Find the agent whose flight passes closest to a point, and write it to the run's ``picks``; return its key."""
    stored, path = write_pick(run, point)
    return {"key": path.parent.name, **stored.result}


def _read_flight(run: Run, design: Design) -> Trajectory:
    """Return the flight of an agent of a run: as it was stored, or flown again if it was unchecked."""
    with run.read() as store:
        record = store.read_record(design.result["evaluation"], run.study.scenario.target_names)
    flight = record.evaluation.trajectory
    return design.fly() if flight is None or flight.error is None else flight


def _read_misses(run: Run, target: str) -> Misses | None:
    with run.read() as store:
        won = find_winner(run.study, store, target)
    return None if won is None else won.misses


def _summarise(misses: Misses | None, target: int) -> dict[str, Any]:
    if misses is None:
        return {"median": None, "p90": None, "flights": 0, "failed": 0}
    return {
        "median": finite_or_none(misses.median[target]),
        "p90": finite_or_none(misses.promised[target]),
        "flights": misses.count,
        "failed": misses.failed,
    }


def _list_effects(misses: Misses | None, target: int) -> list[dict[str, Any]]:
    effects = None if misses is None else divide_spread(misses, target)
    return [{"name": e.name, "deviation": e.deviation, "advice": e.advice} for e in effects or []]
