"""Disturbed conditions of a flight, and the fitness of an agent under them.

The conditions of a run are a design of experiments: a Latin hypercube over all disturbed quantities. All agents are
flown under the same conditions, so that their fitness can be compared.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from driftform.scenario import Robustness, Scenario, TurbulentFlow
from driftform.types import Body, FloatArray

MAX_DEVIATION = 3.0
"""Standard deviations at which a distribution is truncated: a larger deviation would be noticed before use."""

MAX_RADIUS_SHARE = 0.98
"""Largest distance of a disturbed release from the axis, relative to the radius of the bore."""


@dataclass(frozen=True)
class Condition:
    """The deviations of one flight from its scenario.

    Attributes
    ----------
    across
        offset of the release position along the two normals of :func:`draw_normals`, m.
    pitch, yaw
        offsets of the release attitude, rad.
    current, density
        factors on the speed and the density of the water.
    mass
        factor on the density of the hull's material.
    wall
        increase of the thickness of the printed wall, m.
    gusts
        seed of the gusts.
    """

    across: tuple[float, float]
    pitch: float
    yaw: float
    current: float
    density: float
    mass: float
    wall: float
    gusts: int


def draw_conditions(robustness: Robustness, seed: int) -> tuple[Condition, ...]:
    """Return the disturbed conditions of a run with this seed.

    Latin hypercube (McKay, Beckman and Conover 1979, Technometrics 21(2)): for every quantity, each of the n conditions
    lies in a different one of n equally likely intervals. All distributions are normal, truncated at
    :data:`MAX_DEVIATION` standard deviations.
    """
    if not robustness.conditions:
        return ()
    from scipy.stats import qmc, truncnorm

    rng = np.random.default_rng((seed, robustness.conditions))
    shares = qmc.LatinHypercube(8, rng=rng).random(robustness.conditions)
    drawn = truncnorm.ppf(shares, -MAX_DEVIATION, MAX_DEVIATION) * [
        *(robustness.position, robustness.position),
        *np.deg2rad([robustness.angle_deg, robustness.angle_deg]),
        *(robustness.current, robustness.density, robustness.mass, robustness.wall),
    ]
    gusts = rng.integers(2**32, size=robustness.conditions)
    return tuple(
        Condition((x[0], x[1]), x[2], x[3], 1 + x[4], 1 + x[5], 1 + x[6], x[7], int(seed))
        for x, seed in zip(drawn.tolist(), gusts, strict=True)
    )


def disturb_scenario(condition: Condition, scenario: Scenario) -> Scenario:
    """Return the scenario under a disturbed condition."""
    flow = scenario.flow.model_copy(update={"speed": scenario.flow.speed * condition.current})
    if isinstance(flow, TurbulentFlow):
        flow = flow.model_copy(update={"seed": condition.gusts})
    release = scenario.release.model_copy(
        update={
            "position": _shift_release(scenario, condition.across),
            "pitch_deg": scenario.release.pitch_deg + float(np.rad2deg(condition.pitch)),
            "yaw_deg": scenario.release.yaw_deg + float(np.rad2deg(condition.yaw)),
        }
    )
    fluid = scenario.fluid.model_copy(update={"density": scenario.fluid.density * condition.density})
    return scenario.model_copy(update={"flow": flow, "release": release, "fluid": fluid})


def disturb_body(condition: Condition, body: Body) -> Body:
    """Return the body as printed under a disturbed condition.

    A wall that is thicker by d weighs (1 + d / wall) times as much, to first order; the outer contour does not change.
    """
    thicker = max(0.0, 1 + condition.wall / body.wall) if body.wall else 1.0
    return replace(body, hull_density=body.hull_density * condition.mass * thicker)


def robust_fitness(fitness: FloatArray, robustness: Robustness) -> FloatArray:
    """Return the robust fitness, (targets,), from the fitness under all conditions, (conditions, targets).

    It is the mean, the smallest value, or the quantile ``robustness.quantile``, by ``robustness.score``.
    """
    if robustness.score == "mean":
        return np.asarray(fitness.mean(axis=0))
    lowest = 0.0 if robustness.score == "worst" else robustness.quantile
    return np.asarray(np.quantile(fitness, lowest, axis=0))


@dataclass(frozen=True, eq=False)
class Spread:
    """Distribution of the fitness of one agent over the disturbed conditions.

    Attributes
    ----------
    count, failed
        number of flights, and of failed flights, whose fitness is zero.
    mean, tenth, worst
        mean, 10 % quantile and smallest value, %, (targets,) each.
    """

    count: int
    failed: int
    mean: FloatArray
    tenth: FloatArray
    worst: FloatArray

    def document(self, targets: Sequence[str]) -> dict[str, Any]:
        """Return the spread as a JSON document."""
        values = zip(targets, self.mean, self.tenth, self.worst, strict=True)
        return {
            "conditions": self.count,
            "failed": self.failed,
            "targets": {
                name: {"mean": float(m), "quantile_10": float(q), "worst": float(w)}
                for name, m, q, w in values
            },
        }

    def describe(self) -> str:
        """Return the number of flights and of failures in one line."""
        failed = f", {self.failed} of them failed" if self.failed else ""
        return f"disturbed flights: {self.count}{failed}; [robustness] in the scenario sets what varies"


def measure_spread(fitness: FloatArray, failed: int) -> Spread:
    """Return the spread of an agent's fitness, (conditions, targets), with the number of ``failed`` flights."""
    return Spread(
        len(fitness), failed, fitness.mean(axis=0), np.quantile(fitness, 0.1, axis=0), fitness.min(axis=0)
    )


def choose_finalists(fitness: FloatArray, count: int) -> list[int]:
    """Return the rows of fitness (n, targets) that are among the ``count`` best for any target, in ascending order."""
    # With a stable sort the earlier of equal values is chosen.
    best = np.argsort(-fitness, axis=0, kind="stable")[:count]
    return sorted(set(best.ravel().tolist()))


def draw_normals(direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors normal to a direction, (3,) each: one horizontal, and one normal to both.

    >>> [[float(v) for v in n] for n in draw_normals(np.array([1.0, 0.0, 0.0]))]
    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    up = np.array([0.0, 0.0, 1.0]) if abs(direction[2]) < 0.9 else np.array([-1.0, 0.0, 0.0])
    level = np.cross(up, direction)
    level /= np.linalg.norm(level)
    return level, np.asarray(np.cross(direction, level))


def _shift_release(scenario: Scenario, across: Sequence[float]) -> tuple[float, float, float]:
    """Return the release position with its offset, which is halved until it lies inside the bore."""
    shifted = scenario.release_position()
    level, up = draw_normals(scenario.direction())
    offset = across[0] * level + across[1] * up
    while scenario.pipe.segments and not scenario.pipe.contains(tuple(shifted + offset / MAX_RADIUS_SHARE)):
        offset *= 0.5
        if np.linalg.norm(offset) < 1e-6:
            offset = np.zeros(3)
            break
    x, y, z = (np.array(scenario.release.position) + scenario.release_frame().T @ offset).tolist()
    return x, y, z
