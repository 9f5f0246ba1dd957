"""Films of an agent: tracks read and checked against the flight that the model expects, and the model fitted to them."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from driftform import Design
from driftform.agent import hull_mass, mass_properties
from driftform.errors import InputError, did_you_mean
from driftform.water import Factors
from driftform_calibration.bench import Bench, ReleaseError
from driftform_calibration.camera import VIEWS
from driftform_calibration.fit import fit_factors, measure_distance
from driftform_calibration.problem import DISTANCE, Filmed, Problem
from driftform_calibration.result import CalibrationResult
from driftform_calibration.solution import place_releases
from driftform_calibration.tracks import UNITS, Reading, Track, read_track

MAX_SPAN, MIN_SPAN = 5.0, 0.02
"""Extent of a track over what the model can move in that time, outside which its unit is wrong."""

SURE_SIGN = 0.2
"""Net weight over the weight of the hull above which no print sinks that should rise."""

SLOW_MOTION, CLEARLY = (1, 2, 3, 4, 5, 6, 8, 10, 16), 3.0
"""How many times slow a film may be; distance of a track from the flight over that at another speed that is clear."""

SCALES = 1e-3
"""Standard deviation of a weight by scales, relative to it."""


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
    if view not in VIEWS:
        raise InputError(f"--view {view}: unknown view{did_you_mean(view, VIEWS)}; take {', '.join(VIEWS)}")
    for path in map(Path, tracks):
        chosen = scenario or find_scenario(path)
        there = design.under(*settings, scenario=chosen, use=use)
        assert there.agent.morphology is not None
        bench = Bench.of(there.pipeline, there.agent.morphology)
        track = read_track(path, bench.body, reading or Reading())
        films.append(check_film(str(path), Filmed(bench, track, view, scale_error, distance)))
        scenarios.append(chosen or "")
    found = fit_factors(films, names, weigh_prior(films[0].bench, printed_mass))
    return CalibrationResult(design.name, found, design.stored, scenarios)


def find_scenario(track: Path) -> str | None:
    """Return the study file of a film, of the same name in the folder of its track; ``None`` without one."""
    study = track.with_suffix(".toml")
    return str(study) if study != track and study.is_file() else None


def check_film(label: str, film: Filmed) -> Filmed:
    """Return a film, with a note if it may be slow motion or upside down.

    Raises InputError if it is in another unit, or the agent's weight leaves no doubt: one line with the file and the next step.
    """
    _check_motion(label, film)
    track, bench, up = film.track, film.bench, film.axes[:, 2]

    def measure(other: Track) -> float:
        problem = Problem([replace(film, track=other)], (), [1.0])
        return measure_distance(problem.distances(place_releases(problem, problem.start)))

    apart = {slower: measure(replace(track, t=track.t / slower)) for slower in SLOW_MOTION}
    if up.any():
        apart[-1] = measure(replace(track, points=track.points * (1 - 2 * up)))
    best = min(apart, key=lambda kind: apart[kind])
    if apart[1] < CLEARLY * apart[best]:
        return film
    # Forces of the square of the speed: so much less net weight slows an agent as much.
    share, found = 1 - best**-2, f"{best} times slow: give --fps, the frames that the camera takes per second"
    if best == -1:
        share, found = (
            1.0,
            "upside down, or backwards: give --y-down (or --y-up), or export the film as it runs forwards",
        )
    if abs(bench.net_weight) * share > SURE_SIGN * bench.hull_weight:
        raise InputError(f"{label}: follows the model's flight if it is {found}")
    return replace(film, track=replace(track, notes=(*track.notes, f"may be {found}; or weigh the print")))


def _check_motion(label: str, film: Filmed) -> None:
    """Refuse a track in another unit, by the flight that the model expects."""
    track, bench = film.track, film.bench
    duration = float(track.t[-1] - track.t[0])
    path = bench.fly(Factors(), ReleaseError(), duration)
    moved = path.position @ film.axes.T
    expected = float(np.ptp(moved[:, film.seen_axes], axis=0).max())
    fastest = float(np.linalg.norm(path.velocity, axis=1).max()) * duration
    if track.span > MAX_SPAN * max(fastest, 0.01) or track.span < MIN_SPAN * expected:
        close = [u for u, f in UNITS.items() if 0.2 < track.span * f / max(expected, 1e-9) < 5 and f != 1]
        hint = f"give --unit {close[0]}" if close else "check --unit, --scale and --fps"
        raise InputError(
            f"{label}: spans {track.span:.3g} m in {duration:.3g} s, where the model moves {expected:.3g} m: {hint}"
        )


def weigh_prior(bench: Bench, printed_mass: float | None) -> dict[str, tuple[float, float]]:
    """Return the hull's density by the weight of a print: value and deviation of its parameter; nothing without a mass.

    Raises InputError if no print of this agent weighs that.
    """
    if printed_mass is None:
        return {}
    whole, hull = mass_properties(bench.body).mass, hull_mass(bench.body)
    rest = whole - hull
    if not rest < printed_mass < 20 * whole or hull == 0:
        raise InputError(
            f"--printed-mass {printed_mass:g}: in kg, with all that is in it; the agent was simulated with {whole:.4g} kg"
        )
    return {"hull_density": ((printed_mass - rest) / hull - 1.0, SCALES * printed_mass / hull)}


def choose_factors(names: Sequence[str]) -> tuple[str, ...]:
    """Return the factors to fit, all if none is named; ``net_weight`` is that of the hull's density.

    Raises InputError if a factor is unknown.
    """
    known = {**{name: name for name in Factors.names}, "net_weight": "hull_density"}
    for name in names:
        if name not in known:
            raise InputError(f"--fit {name}: unknown factor{did_you_mean(name, known)}; there are {', '.join(known)}")
    wanted = {known[name] for name in names} or set(Factors.names)
    return tuple(name for name in Factors.names if name in wanted)
