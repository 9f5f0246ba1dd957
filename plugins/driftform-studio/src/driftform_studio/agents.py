"""An agent as the page shows it, and the files that can be taken of it."""

import json
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import numpy.typing as npt

from driftform import Design, StoredAgent
from driftform.agent import MassElement, hull_mass
from driftform.errors import InputError, did_you_mean
from driftform.figures import scene, style
from driftform.motion.path import closest_approach
from driftform.search import PipeGrid
from driftform.types import FloatArray
from driftform.util import progress
from driftform.water import Pipe
from driftform_frusta.strength import describe_strength
from driftform_kit.ballast import MATERIALS as BALLAST
from driftform_kit.hang import describe_hanging, trim_in_water
from driftform_kit.trim import trim_design
from driftform_studio.live import LiveRun

Document = dict[str, Any]

FORMATS = {"stl": ("stl", False), "3mf": ("3mf", False), "kit": ("3mf", True)}
"""Downloads for a printer: the exporter of each, and whether it writes a kit."""


def describe_agent(live: LiveRun, key: str, document: Document) -> dict[str, Any]:
    """Return an agent for the page: its body, flight, facts and promise."""
    run, design = live.run, live.find_agent(key)
    scenario, agent, result = run.study.scenario, design.agent, design.result
    flight = run.read_flight(result["evaluation"])  # -1 of an agent that came as a file
    if flight is None or flight.error is None:
        # An unchecked flight is flown again.
        flight = design.trace()
    is_best = key in scenario.targets
    point = scenario.target_points()[key] if is_best else tuple(result["point"])
    [distance], [t] = closest_approach(flight, np.array([point], dtype=np.float64))
    names = list(scenario.targets)
    number = names.index(key) if is_best else len(names)
    colour = style.SERIES[number % len(style.SERIES)] if is_best else style.SERIES[-1]
    found = _describe_misses(run.misses(key) if is_best else None, 0)
    found["promise"]["nominal"] = float(distance)
    strength = describe_strength(agent.body, scenario.fluid) or {}
    return {
        "key": key,
        "target": key if is_best else None,
        "point": list(point),
        "evaluation": result["evaluation"],
        **scene.agent_data(agent, flight, [float(t)], colour),
        "longest": round(agent.body.length, 4),
        **found,
        "file": design.stored.to_text(),
        "name": design.name,
        "limits": design.list_limits(),
        "facts": {
            "length": design.length,
            "diameter": design.max_diameter,
            "mass": design.mass.mass,
            "hull": hull_mass(agent.body),
            "core": agent.body.core.mass,
            "putty": sum(MassElement.of_putty(pocket).mass for pocket in agent.body.pockets),
            "buoyancy": design.net_buoyancy,
            "modules": len(agent.morphology.modules) if agent.morphology else 0,
            "pressure": strength.get("summary", ""),
            "trim": agent.body.trim_range(scenario.fluid.density) if agent.body.pockets else None,
        },
        "number": number,
    }


def disturb_agent(live: LiveRun, key: str, document: Document) -> dict[str, Any]:
    """Fly an agent under disturbed conditions, and return its promise."""
    design, number = _aim(key, live.find_agent(key))
    flights = design.scenario.robustness.checks
    with progress.count_progress("disturbed flights") as show:
        misses = design.disturb(flights, progress=show)
    return _describe_misses(misses, number)


def trim_agent(live: LiveRun, key: str, document: Document) -> dict[str, Any]:
    """Plan ``ballast`` (by name) of a kit that weighs ``grams`` with its core; ``misses`` are those of the agent's target, m."""
    grams = document.get("grams")
    if not isinstance(grams, int | float) or grams <= 0:
        raise InputError("weigh the print with its core, and enter the grams")
    design, number = _aim(key, live.find_agent(key))
    density = BALLAST.get(str(document.get("ballast")))
    facts = trim_design(design, grams / 1000, kit=True, format="3mf", ballast_density=density)
    target = design.scenario.target_names[number]
    kept = ("simulated_mass", "printed_mass", "ballast_mass", "ballast_density", "pieces", "held", "unheld", "aft_end")
    misses = {case: found[target] for case, found in facts["misses"].items()}
    return {name: facts[name] for name in kept} | {"misses": misses, "buoyancy": facts["buoyancy"]}


def hang_agent(live: LiveRun, key: str, document: Document) -> dict[str, Any]:
    """Say what a sealed agent lacks that weighs ``grams`` under water of ``celsius``; ``misses`` are those of its target, m."""
    grams, celsius = document.get("grams"), document.get("celsius")
    if not isinstance(grams, int | float) or not isinstance(celsius, int | float | None):
        raise InputError("hang the sealed agent under water, and enter the grams that the scale shows")
    design, number = _aim(key, live.find_agent(key))
    facts = trim_in_water(design, grams / 1000, celsius)
    target = design.scenario.target_names[number]
    misses = {case: found[target] for case, found in facts["misses"].items()}
    return {"lines": describe_hanging(facts, design.agent.body), "misses": misses}


def _aim(key: str, design: Design) -> tuple[Design, int]:
    """Return an agent with the number of its target; a point that was picked takes the place of the targets."""
    names = design.scenario.target_names
    if key in names:
        return design, names.index(key)
    return design.under(f"targets={{picked = {json.dumps(list(design.result['point']))}}}"), 0


def export_agent(design: Design, kind: str, folder: Path, ballast: Any = None) -> Path:
    """Write an agent for a printer into a folder, and return the file: an archive, if there are several.

    A kit has the options that it was simulated with, but for those of its ``ballast``, if some is given. Its sheet speaks of the page.
    Raises InputError if there is no such kind. Raises WorkFailedError if the agent cannot be written so.
    """
    if kind not in FORMATS:
        raise InputError(f"unknown files '{kind}'{did_you_mean(kind, FORMATS)}")
    format, kit = FORMATS[kind]
    if kit:
        given = design.study.document.get("builder", {}).get("kit") or {}
        options = {**given, **(ballast or {}), "kit": True}
        settings = [f"exporter.{format}.{name}={json.dumps(value)}" for name, value in options.items()]
        design = replace(Design.build(design.stored, design.name, settings=settings), opened_as="")
    path = folder / f"{design.name}{design.study.make_exporter(format).suffix}"
    written = sorted(set(design.export(format, path)))
    if len(written) == 1:
        return written[0]
    archive = folder / f"{design.name}-{kind}.zip"
    with ZipFile(archive, "w", ZIP_DEFLATED) as packed:
        for file in written:
            packed.write(file, file.relative_to(folder))
    return archive


def map_reach(live: LiveRun, key: str, document: Document) -> dict[str, Any]:
    """Return the reach map: the class of each cell by the closest flight, and where the cells lie in the pipe.

    A cell that no flight crosses has the class -1, and one that is not in the pipe -2: outside a narrow bore, or between
    the parts on an unrolled map. ``edges`` has two edges for each column of cells, upstream and downstream, from the lowest to
    the highest point of the map; ``None`` for a column that is not in the pipe. Raises InputError if the run is in open water.
    """
    run = live.run
    reach = run.map_coverage()
    cells, classes = reach.cells, reach.classes
    edges = _place_columns(cells)
    placed: npt.NDArray[np.bool_] = np.asarray(np.isfinite(edges).all(axis=(1, 2, 3)))
    classes[~reach.reached & ~_find_real(cells, run.study.scenario.pipe)] = -2
    classes.reshape(cells.shape)[~placed] = -2
    return {
        "edges": [np.round(e, 4).tolist() if there else None for e, there in zip(edges, placed, strict=True)],
        "columns": cells.shape[0],
        "rows": cells.shape[1],
        "classes": classes.tolist(),
        "colours": list(style.RAMP),
        "bounds": list(reach.bounds),
        "flights": reach.flights,
        "reached": int(reach.reached.sum()),
        "cells": int((classes > -2).sum()),
    }


def _place_columns(cells: PipeGrid) -> FloatArray:
    """Return both edges of each column of a map from bottom to top in the world frame, m, (columns, 2, 2, 3)."""
    columns, rows = cells.shape
    width, top = cells.size[0], 0.5 * rows * cells.size[1]
    # Just within the column: the end of a branch's axis is not the beginning of the gap after it.
    inset = 1e-6 * width
    x = width * np.arange(columns)[:, None] + np.array([inset, width - inset])
    corners = np.stack(np.broadcast_arrays(x[:, :, None], np.array([-top, top])), axis=-1)
    return cells.to_world(corners.reshape(-1, 2)).reshape(columns, 2, 2, 3)


def _find_real(cells: PipeGrid, pipe: Pipe) -> npt.NDArray[np.bool_]:
    """Return which cells of a map have their centre in the pipe at the place that the map says, (cells,)."""
    centres = cells.centres()
    world = cells.to_world(centres)
    real: npt.NDArray[np.bool_] = np.asarray(np.isfinite(world).all(axis=1))
    real[real] = pipe.layout.find_part(world[real]) >= 0
    # Where a branch leaves, the map of the run and that of the branch overlap: each point is on one of them.
    real[real] = np.abs(cells.to_map(world[real])[:, :2] - centres[real]).max(axis=1) < 1e-6
    return real


def pick(live: LiveRun, key: str, document: Document) -> dict[str, Any]:
    """Find the agent whose flight passes closest to a ``point``, and write it to the run's ``picks``; return its key."""
    match document.get("point"):
        case [int() | float() as x, int() | float() as y, int() | float() as z]:
            path = live.run.write_pick(round(float(x), 4), round(float(y), 4), round(float(z), 4))
            return {"key": path.parent.name, **StoredAgent.read(path).result}
    raise InputError(f"point = {document.get('point')!r}: should be three numbers, in m")


def write_report(live: LiveRun, key: str, document: Document) -> dict[str, Any]:
    """Write the report of a run."""
    return {"bytes": live.run.report().stat().st_size}


WORK: dict[str, Callable[[LiveRun, str, Document], dict[str, Any]]] = {
    "show": describe_agent,
    "disturb": disturb_agent,
    "trim": trim_agent,
    "hang": hang_agent,
    "reach": map_reach,
    "pick": pick,
    "report": write_report,
}
"""Functions that run as tasks; they take a run, the key of an agent, and the document of the request."""


def _describe_misses(misses: Any, target: int) -> dict[str, Any]:
    """Return what disturbed flights promise for a target, and the effects of each disturbance."""
    if misses is None:
        return {"promise": {"median": None, "p90": None, "flights": 0, "failed": 0}, "effects": []}
    effects = [asdict(effect) for effect in misses.list_effects(target) or []]
    return {"promise": dict(misses.describe(target)), "effects": effects}
