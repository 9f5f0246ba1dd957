"""Disturbed conditions of a flight: how they are drawn, and which values they change.

The conditions of a run are a design of experiments: a Latin hypercube over all disturbed quantities. All agents are
flown under the same conditions, so that their misses can be compared.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from driftform.types import FloatArray
from driftform.water import Calibration, Fluid, Scenario
from driftform.water.factors import DRAGS
from driftform.water.flow import PipeFlow, UniformFlow
from driftform.water.pipe import Pipe
from driftform.water.scenario import Robustness

MAX_DEVIATION = 3.0
"""Standard deviations at which a distribution is truncated: a larger deviation would be noticed before use."""

BEYOND = 0.0013498980316300933
"""Share of a normal distribution that lies beyond them on either side: ``scipy.special.ndtr(-MAX_DEVIATION)``."""

LEVEL = 1e-9
"""Largest slope of a pipe that counts as level."""

MAX_RADIUS_SHARE = 0.98
"""Largest distance of a disturbed release from the axis, relative to the radius of the bore."""


SCALE = 0.00005
"""Smallest step of the scale that weighs a print, and of its ballast, kg."""

THERMOMETER = 0.5
"""Largest error of the difference of two readings of a thermometer, K, evenly spread."""

COEFFICIENT = 0.2
"""Standard deviation of a hull's thermal expansion, and of what it loses under pressure, relative to the values in use.

Data sheets of one kind of plastic differ by so much: those of ABS have 70e-6 to 100e-6 1/K and 2.0 to 2.9 GPa.
"""

KNOWN = (1.0, 1.0, 1.0)
"""Factors on strength, memory and crossing of gusts that are as ``[gusts]`` describes them."""


class Specimen(StrEnum):
    """The body that flies under a condition."""

    PRINT = "print"
    """The print, neither weighed nor trimmed."""
    WEIGHED = "weighed"
    """The print, weighed in water and trimmed with ballast, each to the nearest :data:`SCALE`."""
    WEIGHED_IN_AIR = "weighed in air"
    """The same, weighed in air: its mass is that of the design, and its volume is not known. No run flies it."""
    IDLE = "idle"
    """A neutral sphere of the agent's volume, in its place."""
    BASELINE = "baseline"
    """The plain body that was tuned for the target, weighed and trimmed as the print is."""


FLOWN = (Specimen.PRINT, Specimen.WEIGHED, Specimen.IDLE)
"""What flies under the conditions of the promise, in this order; the baseline of each target follows."""


@dataclass(frozen=True)
class Condition:
    """The deviations of one flight from its scenario; by default there are none.

    Attributes:
        across: offset of the release position along the two normals of :func:`draw_normals`, m.
        pitch, yaw: offsets of the release attitude, rad.
        current, density: factors on the speed and the density of the water.
        mass: factor on the density of the hull's material.
        wall: increase of the thickness of the printed wall, m.
        drag: factor on all forces of drag and damping that are not calibrated.
        gusts: seed of the gusts, ``None`` for steady water.
        calibrated: values of the factors that have an interval in ``[calibration]``, in the order of
            :attr:`driftform.water.Calibration.intervals`.
        swirl: increase of the secondary flow of bends, relative to the mean speed.
        left: excess mass of a weighed and trimmed print, kg.
        outside: outward offset of the outer surface, m.
        scale: factor on all lengths of the print.
        warmer: temperature in flight less that at which the body is designed or trimmed, K.
        read: what the thermometers say of it too much, K.
        expanded, squeezed: factors on the hull's coefficient of thermal expansion, and on what it loses under pressure.
        absorbed: mass of water that the hull takes up, relative to its own.
        bubble: volume of air that clings to the body, less that when it was weighed, m3.
        turbulence: factors on strength, memory and crossing of the gusts.
        specimen: the body that flies.
    """

    across: tuple[float, float] = (0.0, 0.0)
    pitch: float = 0.0
    yaw: float = 0.0
    current: float = 1.0
    density: float = 1.0
    mass: float = 1.0
    wall: float = 0.0
    drag: float = 1.0
    gusts: int | None = None
    calibrated: tuple[float, ...] = ()
    swirl: float = 0.0
    left: float = 0.0
    outside: float = 0.0
    scale: float = 1.0
    warmer: float = 0.0
    read: float = 0.0
    expanded: float = 1.0
    squeezed: float = 1.0
    absorbed: float = 0.0
    bubble: float = 0.0
    turbulence: tuple[float, float, float] = KNOWN
    specimen: Specimen = Specimen.PRINT


def draw_conditions(
    robustness: Robustness, count: int, seed: Sequence[int], calibration: Calibration | None = None
) -> tuple[Condition, ...]:
    """Return ``count`` disturbed conditions, drawn from a seed; ``calibration`` has the factors with an interval.

    They are a Latin hypercube. All distributions are normal, truncated at :data:`MAX_DEVIATION` standard deviations, but for
    what is left of the error of a weighed print: the scale and the ballast are each off by up to half a step, evenly.
    """
    from scipy.special import ndtri

    if not count:
        return ()
    deviations = [
        *(robustness.position, robustness.position),
        *np.deg2rad([robustness.angle_deg, robustness.angle_deg]),
        *(robustness.current, robustness.density, robustness.mass, robustness.wall, robustness.drag),
    ]
    rng = np.random.default_rng(tuple(seed))
    calibration = calibration or Calibration()
    first, second, third, fourth = rng.spawn(4)
    shares = draw_latin_hypercube(first, count, len(deviations) + len(calibration.intervals))
    deviates = ndtri(BEYOND + (1 - 2 * BEYOND) * shares)
    # The sign of a secondary flow is known.
    cells = ndtri(0.5 + (0.5 - BEYOND) * draw_latin_hypercube(second, count, 1)[:, 0])
    drawn = deviates[:, : len(deviations)] * deviations
    factors = calibration.draw_factors(deviates[:, len(deviations) :]).tolist()
    gusts: list[int | None] = [None] * count
    if robustness.gusts:
        gusts = rng.integers(2**32, size=count).tolist()
    left = SCALE * (shares[:, 6] + shares[:, 7] - 1)
    doubts = (robustness.gust_strength, robustness.gust_memory, robustness.gust_crossing)
    shares = draw_latin_hypercube(third, count, len(doubts))
    turbulence = map(tuple, (1 + doubts * ndtri(BEYOND + (1 - 2 * BEYOND) * shares)).tolist())
    swirls = (robustness.swirl * cells).tolist()
    hulls = _draw_hulls(robustness, draw_latin_hypercube(fourth, count, 8))
    rows = zip(drawn.tolist(), gusts, factors, swirls, left.tolist(), hulls.tolist(), turbulence, strict=True)
    return tuple(
        Condition(
            (x[0], x[1]),
            *(x[2], x[3], 1 + x[4], 1 + x[5], 1 + x[6], x[7], 1 + x[8]),
            *(gust, tuple(known), swirl, excess, *hull, doubt),
        )
        for x, gust, known, swirl, excess, hull, doubt in rows
    )


def _draw_hulls(robustness: Robustness, shares: FloatArray) -> FloatArray:
    """Return ``outside`` to ``bubble`` of conditions, (count, 8), from the shares of a Latin hypercube of that size."""
    from scipy.special import ndtri

    deviates = ndtri(BEYOND + (1 - 2 * BEYOND) * shares)
    columns = [
        robustness.outside * deviates[:, 0],
        1 + robustness.shrinkage * deviates[:, 1],
        robustness.temperature * deviates[:, 2],
        THERMOMETER * (2 * shares[:, 3] - 1),
        1 + COEFFICIENT * deviates[:, 4],
        1 + COEFFICIENT * deviates[:, 5],
        robustness.absorbed * np.abs(deviates[:, 6]),
        robustness.bubble * deviates[:, 7],
    ]
    return np.column_stack(columns)


def know_gusts(conditions: Sequence[Condition], scenario: Scenario) -> tuple[Condition, ...]:
    """Return the conditions with the same gusts, but as ``[gusts]`` describes them; none if they are all so already."""
    known = tuple(replace(condition, turbulence=KNOWN) for condition in conditions)
    has_doubt = scenario.can_have_gusts and scenario.robustness.gusts and known != tuple(conditions)
    return known if has_doubt else ()


def draw_latin_hypercube(rng: np.random.Generator, count: int, quantities: int) -> FloatArray:
    """Return shares between 0 and 1, (count, quantities): in each column, every interval of 1 / count holds one.

    McKay, Beckman and Conover 1979, Technometrics 21(2). The numbers are those of ``scipy.stats.qmc.LatinHypercube``, a package that
    takes longer to import than a simulation.
    """
    within = rng.uniform(size=(count, quantities))
    intervals = np.tile(np.arange(1, count + 1), (quantities, 1))
    for row in intervals:
        rng.shuffle(row)
    return np.asarray((intervals.T - within) / count)


def disturb_scenario(condition: Condition, scenario: Scenario) -> Scenario:
    """Return the scenario under a disturbed condition."""
    flow, gusts = scenario.flow, scenario.gusts
    flow = flow.model_copy(update={"speed": flow.speed * condition.current})
    if isinstance(flow, UniformFlow):
        flow = flow.model_copy(update={"added": tuple(condition.current * v for v in flow.added)})
    if isinstance(flow, PipeFlow):
        flow = flow.model_copy(update={"swirl": flow.swirl + condition.swirl})
    if condition.gusts is not None and scenario.can_have_gusts:
        names = ("strength", "memory", "crossing")
        factors = zip(names, condition.turbulence, strict=True)
        gusts = gusts.model_copy(
            update={
                "always": True,
                "seed": condition.gusts,
                **{name: factor * getattr(gusts, name) for name, factor in factors},
            }
        )
    release = scenario.release.model_copy(
        update={
            "position": _shift_release(scenario, condition.across),
            "pitch_deg": scenario.release.pitch_deg + float(np.rad2deg(condition.pitch)),
            "yaw_deg": scenario.release.yaw_deg + float(np.rad2deg(condition.yaw)),
            # Designs pass the port with play; a print that is a little wider does too.
            "port": 0.0,
        }
    )
    return scenario.model_copy(
        update={
            "flow": flow,
            "gusts": gusts,
            "release": release,
            "fluid": disturb_fluid(condition, scenario.fluid),
            "calibration": disturb_calibration(condition, scenario.calibration),
        }
    )


def stop_after_targets(scenario: Scenario, wanted: Sequence[bool]) -> Scenario:
    """Return the scenario with a level, straight pipe that ends one bore after its last ``wanted`` target.

    A flight that is so far is farther from each than it was where it passed them, and does not come back: nothing but the
    water moves it along the axis. Upstream nothing changes: the flow does not depend on the pipe after it. Another pipe stays whole, and
    so does one that ends before.
    """
    straight, targets = scenario.pipe.straight, scenario.target_array()[np.array(wanted, bool)]
    if straight is None or not len(targets) or not isinstance(scenario.flow, PipeFlow):
        return scenario
    start, whole = np.array(straight.start), np.subtract(straight.end, straight.start)
    length = float(np.linalg.norm(whole))
    along = ((np.vstack([targets, scenario.release_position()]) - start) @ whole) / length
    share = (float(along.max()) + 2 * straight.radius) / length
    if not share < 1 or abs(whole[2]) > LEVEL * length:
        return scenario
    x, y, z = (start + share * whole).tolist()
    segment = straight.model_copy(update={"end": (x, y, z)})
    return scenario.model_copy(update={"pipe": Pipe(segments=(segment,))})


def disturb_fluid(condition: Condition, fluid: Fluid) -> Fluid:
    """Return the water under a disturbed condition."""
    celsius = fluid.celsius + condition.warmer
    density = condition.density * fluid.density_at(celsius)
    return fluid.model_copy(update={"name": "", "density": density, "celsius": celsius})


def disturb_calibration(condition: Condition, calibration: Calibration) -> Calibration:
    """Return the factors under a condition: drawn from their intervals; drags without one are disturbed together."""
    drawn = dict(zip(calibration.intervals, condition.calibrated, strict=True))
    for name in DRAGS:
        if name not in drawn and condition.drag != 1.0:
            drawn[name] = condition.drag * getattr(calibration.factors, name)
    return calibration.with_factors(replace(calibration.factors, **drawn)) if drawn else calibration


def draw_normals(direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors normal to a direction, (3,) each: one horizontal, and one normal to both.

    >>> [[float(v) for v in n] for n in draw_normals(np.array([1.0, 0.0, 0.0]))]
    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    up = np.array([0.0, 0.0, 1.0]) if abs(direction[2]) < 0.9 else np.array([-1.0, 0.0, 0.0])
    level = np.cross(up, direction)
    level /= np.linalg.norm(level)
    return level, np.cross(direction, level)


def _shift_release(scenario: Scenario, across: Sequence[float]) -> tuple[float, float, float]:
    """Return the release position with its offset, which is halved until it lies inside the bore."""
    shifted = scenario.release_position()
    level, up = draw_normals(scenario.direction())
    offset = across[0] * level + across[1] * up
    while not scenario.pipe.is_open and not scenario.pipe.contains(tuple(shifted + offset / MAX_RADIUS_SHARE)):
        offset *= 0.5
        if np.linalg.norm(offset) < 1e-6:
            offset = np.zeros(3)
            break
    x, y, z = (np.array(scenario.release.position) + scenario.release_frame().T @ offset).tolist()
    return x, y, z
