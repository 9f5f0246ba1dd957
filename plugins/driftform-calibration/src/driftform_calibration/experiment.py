"""Which drops to film: those whose tracks are expected to show most about the factors.

Around the model as it is, a film shows of the factors what its residuals' derivatives say (Fisher information), after
what it must show of its own release and camera. The gain of a drop is the entropy of the factors that it removes, in bits,
for normal distributions (Lindley 1956; Chaloner and Verdinelli 1995, Statistical Science 10(3), on D-optimal designs).
Drops are chosen one after the other; the gain is submodular, so that the choice has at least 63 % of the best gain.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from driftform import Design
from driftform.errors import InputError, WorkFailedError
from driftform.types import Body, FloatArray
from driftform.util import progress
from driftform.water import Calibration, Factors, Pipe, Scenario, Segment
from driftform_calibration.bench import Bench, Path, ReleaseError
from driftform_calibration.fit import CONTACT, find_max_width, list_reasons
from driftform_calibration.problem import Filmed, Problem, factor_of
from driftform_calibration.protocol import CAMERA, Drop, DropPlan, Tank
from driftform_calibration.tracks import Track

FLOOR_RADIUS = 100.0
"""Radius of the tube whose lowest line is the floor of a tank, m: flat to half a millimetre within 0.3 m."""

PITCHES_DEG = (-90.0, -60.0, -30.0, 0.0, 30.0, 60.0, 90.0)
"""Pitches of a release that are tried."""

BALLASTS, SINKING = (0.0, 0.3, 1.0), (1.3, 2.0)
"""Weights in water of a ballast that are tried, over the agent's net weight; the latter make an agent sink that floats."""

MARGIN = 0.02
"""Water that is left around the agent at the release, m."""

AFTER_FLOOR = 0.4
"""Time that is filmed after the agent reaches the floor, s."""

MAX_DURATION = 20.0
"""Longest film, s."""

MIN_FRAMES = 8
"""Fewest frames of a film that is worth making."""


def drop_design(
    design: Design,
    tank: tuple[float, float, float] = (1.0, 0.5, 0.5),
    *,
    drops: int = 3,
    fps: float = 60.0,
    noise: float = 0.002,
) -> DropPlan:
    """Return the drops in a tank whose films show most about the model, in the water of an agent's scenario.

    Args:
        tank: inside of the tank: along the picture, across it, and the depth of the water, m.
        drops: number of drops.
        fps: frames of the films per second.
        noise: standard deviation of a tracked point, m.

    Raises:
        InputError: if the tank is smaller than the agent.
        WorkFailedError: if no release can be filmed.
    """
    given = f"--tank {' '.join(f'{size:g}' for size in tank)}"
    if min(tank) < design.max_diameter or max(tank) < max(design.length, design.max_diameter):
        raise InputError(
            f"{given}: the agent is {design.length:.3g} m long and {design.max_diameter:.3g} m wide; the tank must be "
            "larger, in m"
        )
    assert design.agent.morphology is not None
    inside, bench = Tank(*tank), Bench.of(design.pipeline, design.agent.morphology)
    candidates = list_candidates(bench, inside)
    found: list[tuple[Drop, FloatArray]] = []
    names: tuple[str, ...] = ()
    reasons: dict[str, str] = {}
    for scenario in progress.track_progress(candidates, len(candidates), "releases"):
        there = Bench(bench.body, bench.coefficients, scenario)
        reasons = list_reasons([Filmed(there, _blank(np.zeros(1)))], Factors.names)
        names = tuple(name for name in Factors.names if name not in reasons)
        examined = _examine(there, inside, names, fps, noise)
        if examined is not None:
            found.append(examined)
    if not found:
        raise WorkFailedError(
            f"no release in a tank of {inside.length:g} x {inside.width:g} x {inside.depth:g} m can be filmed for "
            f"{MIN_FRAMES} frames at {fps:g} frames/s: take a deeper tank, or more frames"
        )
    plan = design.name, design.agent, inside, design.study.document
    return DropPlan(
        *plan, *_choose(found, names, bench, drops), reasons, bench.hull_weight / max(abs(bench.net_weight), 1e-12)
    )


def list_candidates(bench: Bench, tank: Tank) -> list[Scenario]:
    """Return the scenarios of all releases that are compared."""
    body, density = bench.body, bench.scenario.fluid.density
    ballast_density = bench.scenario.release.ballast_density
    shares = BALLASTS if bench.net_weight > 0 else (0.0, *SINKING)
    found = []
    for pitch_deg, share in product(PITCHES_DEG, shares):
        sinks = bench.net_weight > 0 or share > 0
        above, below, aside = _measure_reach(body, np.deg2rad(pitch_deg))
        depth = above + MARGIN if sinks else tank.depth - below - MARGIN
        if above + below + 3 * MARGIN > tank.depth or 2 * aside > tank.length:
            continue
        weight = share * abs(bench.net_weight) / bench.scenario.fluid.gravity
        mass = round(weight / (1 - density / ballast_density), 4)
        found.append(tank_scenario(bench.scenario, tank, pitch_deg, depth, mass))
    return found


def tank_scenario(like: Scenario, tank: Tank, pitch_deg: float, depth: float, ballast: float) -> Scenario:
    """Return the scenario of a release from rest in a tank, with the water and the contact of another; the surface is at z = 0."""
    axis = FLOOR_RADIUS - tank.depth
    release = like.release.model_copy(
        update={
            "frame": "world",
            "position": (0.0, 0.0, -float(depth)),
            "pitch_deg": float(pitch_deg),
            "yaw_deg": 0.0,
            "velocity": "rest",
            "ballast": float(ballast),
            "ballast_x": 0.0,
        }
    )
    segment = Segment(start=(-50.0, 0.0, axis), end=(50.0, 0.0, axis), radius=FLOOR_RADIUS)
    return like.model_copy(update={"pipe": Pipe(segments=(segment,)), "release": release, "targets": {}})


def _examine(
    bench: Bench, tank: Tank, names: Sequence[str], fps: float, noise: float
) -> tuple[Drop, FloatArray] | None:
    """Return a drop, and the information of its film about the factors, (factors, factors); ``None`` if it is too short."""
    path = bench.fly(Factors(), ReleaseError(), MAX_DURATION)
    duration, end = _find_end(bench.body, path, tank)
    t = np.arange(0.0, duration, 1 / fps)
    if len(t) < MIN_FRAMES:
        return None
    inform = partial(_inform, bench, names, noise, CAMERA * tank.length)
    information = inform(t)
    if path.contact < duration:
        # A fit takes drag and weight from free flight alone.
        free = np.array([name not in CONTACT for name in names])
        before = t[t < path.contact]
        falling = inform(before) if len(before) >= MIN_FRAMES else 0.0
        information = np.where(np.outer(free, free), falling, np.where(np.outer(~free, ~free), information, 0.0))
    points, _ = path.points_at(t)
    return Drop(bench.scenario, duration, end, 0.0, points[:, [0, 2]]), information


def _inform(bench: Bench, names: Sequence[str], noise: float, distance: float, t: FloatArray) -> FloatArray:
    """Return what a film with frames at ``t`` (s) shows of the factors, (factors, factors), without its own unknowns."""
    film = Filmed(bench, _blank(t), distance=distance)
    problem = Problem([film], names, [noise])
    jacobian, count = problem.jacobian(problem.start), len(names)
    whole = jacobian.T @ jacobian
    # What is known of the factors before counts once, not with each film.
    whole[:count, :count] -= np.diag([1 / p.prior**2 for p in problem.parameters[:count]])
    across = whole[:count, count:]
    left = whole[:count, :count] - across @ np.linalg.pinv(whole[count:, count:], hermitian=True) @ across.T
    return np.asarray((left + left.T) / 2)


def _blank(t: FloatArray) -> Track:
    """Return a track of the core at times ``t`` (s), whose points do not matter."""
    return Track("", t, np.zeros((1, len(t), 2)))


def _find_end(body: Body, path: Path, tank: Tank) -> tuple[float, str]:
    """Return when (s) a film ends, and where the agent is then."""
    t, position = path.t, path.position
    reach = np.array([_measure_reach(body, p) for p in -np.arcsin(np.clip(path.axis[:, 2], -1, 1))])
    top, wide = position[:, 2] + reach[:, 0], np.abs(position[:, 0]) + reach[:, 2]
    ends = {"time": float(t[-1])}
    if (top > 0).any():
        ends["surface"] = float(t[np.argmax(top > 0)])
    if (wide > tank.length / 2).any():
        ends["side"] = float(t[np.argmax(wide > tank.length / 2)])
    if path.contact < np.inf:
        ends["floor"] = path.contact + AFTER_FLOOR
    first = min(ends, key=lambda name: ends[name])
    return ends[first], first


def _measure_reach(body: Body, pitch: float) -> tuple[float, float, float]:
    """Return how far a body reaches above its core's centre, below it and aside, m; ``pitch`` (rad) is positive nose down."""
    (x, r), c, s = body.outer.T, abs(np.cos(pitch)), np.sin(pitch)
    above, below, aside = r * c - x * s, r * c + x * s, np.abs(x) * c + r * abs(s)
    return float(above.max()), float(below.max()), float(aside.max())


def _choose(
    found: Sequence[tuple[Drop, FloatArray]], names: tuple[str, ...], bench: Bench, count: int
) -> tuple[tuple[Drop, ...], dict[str, tuple[float, bool]]]:
    """Return the drops in the order of their gain, and what they are expected to show of the factors."""
    problem = Problem([Filmed(bench, _blank(np.linspace(0, 1, 8)))], names, [1.0])
    priors = np.array([p.prior for p in problem.parameters[: len(names)]])
    information, drops = np.diag(priors**-2.0), []
    for _ in range(count):
        before = np.linalg.slogdet(information)[1]
        gains = [(np.linalg.slogdet(information + more)[1] - before) / 2 / np.log(2) for _, more in found]
        best = int(np.argmax(gains))
        information = information + found[best][1]
        drops.append(replace(found[best][0], gain=float(gains[best])))
    deviation = np.sqrt(np.diag(np.linalg.inv(information)))
    expected = {}
    for name, width in zip(names, Calibration.quantile * deviation, strict=True):
        half = (factor_of(name, width) - factor_of(name, -width)) / 2
        expected[name] = (float(half), bool(half <= find_max_width(bench, name, 1.0)))
    return tuple(drops), expected
