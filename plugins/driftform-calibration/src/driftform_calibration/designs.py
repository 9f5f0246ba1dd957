"""Calibrate an agent by films of its flights, and plan the drops to film: the commands, for scripts."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from driftform import Design
from driftform.errors import InputError
from driftform_calibration.bench import Bench
from driftform_calibration.experiment import Tank, plan_drops
from driftform_calibration.films import choose_factors, film_track, find_scenario, weigh_prior
from driftform_calibration.fit import fit_factors
from driftform_calibration.problem import DISTANCE
from driftform_calibration.protocol import DropPlan
from driftform_calibration.result import CalibrationResult
from driftform_calibration.tracks import Reading

Progress = Callable[[int, int], None]
"""Takes the number of steps that are done, and of all."""


def calibrate_design(
    design: Design,
    *tracks: str | os.PathLike[str],
    scenario: str | None = None,
    settings: Sequence[str] = (),
    use: Mapping[str, str | None] | None = None,
    reading: Reading | None = None,
    view: str = "side",
    scale_error: float = 0.005,
    distance: float = DISTANCE,
    fit: Sequence[str] = (),
    printed_mass: float | None = None,
) -> CalibrationResult:
    """Return what films of an agent's flights show of the model, as ``driftform calibrate`` does.

    Args:
        tracks: files of tracks, one for each film. A study file of the same name in the folder of a track, such
            as ``drop-1.toml`` for ``drop-1.csv``, is the scenario of that film.
        scenario: of all films, in place of such files; ``None`` for these, or for that of the agent.
        settings, use: of the scenarios of the films, as for :meth:`under`.
        reading: units, frames and points of the tracks; ``None`` for metres and seconds.
        view: of the camera: ``"side"``, ``"top"`` or ``"front"``; tracks with x, y and z have none.
        scale_error: standard deviation of a film's scale, relative to it.
        distance: of the camera, m: the nearer, the more do heights bend if it looks down.
        fit: names of the factors to fit; empty for all.
        printed_mass: mass of the print with core and ballast, kg, by scales; ``None`` if it was not weighed.

    Raises:
        InputError: if a track is not that of a flight of this agent.
        WorkFailedError: if the agent cannot be flown.
    """

    names, films, scenarios = choose_factors(fit), [], []
    if not tracks:
        raise InputError("name at least one track")
    for path in map(Path, tracks):
        chosen = scenario or find_scenario(path)
        there = design.under(*settings, scenario=chosen, use=use)
        assert there.agent.morphology is not None
        bench = Bench.of(there.pipeline, there.agent.morphology)
        films.append(film_track(path, bench, reading or Reading(), view, scale_error, distance))
        scenarios.append(chosen or "")
    found = fit_factors(films, names, weigh_prior(films[0].bench, printed_mass))
    return CalibrationResult(design.name, found, design.stored, scenarios)


def drop_design(
    design: Design,
    tank: tuple[float, float, float] = (1.0, 0.5, 0.5),
    *,
    drops: int = 3,
    fps: float = 60.0,
    noise: float = 0.002,
    progress: Progress = lambda _, __: None,
) -> DropPlan:
    """Return the drops in a tank whose films show most about the model, in the water of an agent's scenario.

    Args:
        tank: inside of the tank: along the picture, across it, and the depth of the water, m.
        drops: number of drops.
        fps: frames of the films per second.
        noise: standard deviation of a tracked point, m.
        progress: called with the number of releases that were examined, and of all.

    Raises:
        InputError: if the tank is smaller than the agent.
        WorkFailedError: if no release can be filmed.
    """

    given = f"--tank {' '.join(f'{size:g}' for size in tank)}"
    if not all(0 < size < 50 for size in tank):
        raise InputError(f"{given}: sizes should be from 0 to 50 m")
    if min(tank) < design.max_diameter or max(tank) < max(design.length, design.max_diameter):
        raise InputError(
            f"{given}: the agent is {design.length:.3g} m long and {design.max_diameter:.3g} m wide; the tank must be "
            "larger, in m"
        )
    assert design.agent.morphology is not None
    inside = Tank(*tank)
    plan = plan_drops(design.pipeline, design.agent.morphology, inside, drops, fps, noise, progress)
    return DropPlan(design.name, design.agent, inside, plan, design.study.document)
