"""What is known about a study before its first flight: that nothing fits, or what no flight can reach.

Each warning is one line with the numbers and the next step. All of it takes a fraction of a second: nothing flies.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from driftform.errors import InputError, find_commonest
from driftform.motion.forces.limits import list_limits
from driftform.pipeline import Pipeline
from driftform.types import Body, FloatArray, Morphology
from driftform.water import Scenario
from driftform.water.factors import DRAGS
from driftform.water.field import wall_distance
from driftform.water.flow import PowerLawFlow, UniformFlow, is_laminar
from driftform.water.misfit import find_misfit, show_length
from driftform.water.parts.shapes import Bend
from driftform.water.regime import warn_of_regime

NEGLIGIBLE = 1e-3
"""Distance (m) that no warning is worth: the accuracy of a flight."""

CENTRE_SPEED = 1.4
"""Bound on the speed on the axis relative to the mean, in developed turbulent flow.

The logarithmic law has 3 u* / (2 kappa) = 1.29 sqrt(f) times the mean between the two; f is at most 0.07, that of the
largest roughness that a study may have, a twentieth of the diameter (Colebrook).
"""

LAMINAR_SPEED = 2.0
"""The same in laminar flow, exactly (Hagen and Poiseuille)."""

OWN_SPEED = 1.0
"""Speed (m/s) that weight or buoyancy may give a body along a vertical pipe: more than agents reach."""

PATIENCE = 100
"""Horizon over the time in which the water passes the pipe that is certainly longer than needed."""

MIN_BEND_RADIUS = 1.0
"""Smallest radius of elbows for butt welding, "short radius", over the diameter of the pipe (ASME B16.9)."""

MIN_BEND_DEG = 2 * np.pi
"""Angle in degrees below which that of a bend may have been meant in radians; fittings begin at 11.25 degrees (EN 545)."""

MAX_SLIGHT_DEG = 0.2
"""Angle in degrees of a release below which radians may have been meant; nobody sets an attitude that closely."""

SAMPLED_AGENTS = 12
"""Random agents that are built to see whether they fit."""

MAX_DENSITY = 22_600.0
"""Density of osmium, the densest material there is, kg/m3 (CRC Handbook of Chemistry and Physics)."""


def list_warnings(name: str, pipeline: Pipeline) -> list[str]:
    """Return what is likely to be wrong with the study of a pipeline, one line each; ``name`` is what errors call it.

    Raises InputError if not even the smallest body of the builder can be released.
    """
    return _Advice(name, pipeline).collect()


class _Advice:
    def __init__(self, name: str, pipeline: Pipeline) -> None:
        self.name, self.pipeline = name, pipeline
        self.scenario: Scenario = pipeline.scenario

    def collect(self) -> list[str]:
        bare = self._build_bare()
        if bare is not None and (misfit := find_misfit(bare, self.scenario)) is not None:
            raise InputError(
                f"{self.name}: no agent can be released: the bare core in its hull, the smallest body of builder "
                f"'{self.pipeline.builder.name}': {misfit}"
            )
        found = [*self._check_units(), *self._check_water(), *warn_of_regime(self.scenario)]
        if bare is not None:
            found += self._check_bare(bare)
        if self.scenario.pipe.straight is not None:
            found += [*self._check_plane(), *self._check_drift()]
        if not self.scenario.pipe.is_open:
            found += [*self._check_bends(), *self._check_limits()]
            found += self._check_places(bare)
        return [*found, *self._check_targets(), *self._check_random_agents()]

    def _build_bare(self) -> Body | None:
        """The body without modules; ``None`` if the builder cannot make it."""
        try:
            return self.pipeline.build(Morphology())
        except Exception:
            # Genomes of its grammar may all have modules. Each that cannot be built is a failure of its own.
            return None

    @cached_property
    def _start(self) -> FloatArray:
        return self.scenario.release_position()

    def _check_units(self) -> Iterator[str]:
        fluid, flow = self.scenario.fluid, self.scenario.flow
        if not self.scenario.pipe.is_open:
            length, radius = self.scenario.pipe.layout.longest_path, self.scenario.pipe.layout.inlet.radius
            if length > 1000 or radius > 10:
                yield (
                    f"the pipe is {length:g} m long with a radius of {radius:g} m: lengths are in metres; "
                    "divide millimetres by 1000"
                )
            elif length < 2 * radius:
                yield f"the pipe is {length:g} m long and {2 * radius:g} m wide: check start, end and radius"
        if abs(flow.speed) > 10:
            yield f"flow.speed = {flow.speed:g} m/s is more than water mains have (about 3 m/s): it is in m/s"
        if not 500 <= fluid.density <= 1500 and not fluid.name:
            yield f"fluid.density = {fluid.density:g} kg/m3 is not that of water, about 1000: it is in kg/m3"
        if not 1e-7 <= fluid.viscosity <= 1e-5 and not fluid.name:
            yield (
                f"fluid.viscosity = {fluid.viscosity:g} m2/s is not that of water, about 1e-6: it is kinematic, "
                "in m2/s (1 cSt is 1e-6)"
            )
        for name in ("pitch_deg", "yaw_deg", "roll_deg"):
            angle = getattr(self.scenario.release, name)
            if 0 < abs(angle) < MAX_SLIGHT_DEG:
                yield f"release.{name} = {angle:g} is in degrees; did you mean {np.rad2deg(angle):.3g}?"
        if not 1 <= fluid.gravity <= 25:
            yield f"fluid.gravity = {fluid.gravity:g} m/s2 is not the Earth's 9.81: it is in m/s2"

    def _check_water(self) -> Iterator[str]:
        level, segment = self.scenario.fluid.water_level, self.scenario.pipe.straight
        if level is None:
            return
        if segment is not None:
            axis = self.scenario.direction()
            top = max(segment.start[2], segment.end[2]) + segment.radius * float(np.hypot(axis[0], axis[1]))
            if level > top:
                yield (
                    f"fluid.water_level = {level:g} m is above the whole pipe, whose top is at z {top:g} m: "
                    "leave it out for a full pipe"
                )
        heights = {name: point[2] - level for name, point in self.scenario.target_points().items()}
        dry = {name: height for name, height in heights.items() if height > NEGLIGIBLE}
        if dry:
            height = show_length(max(dry.values()))
            yield f"{_say_lie(dry)} above the water, by up to {height}: fluid.water_level = {level:g} m"

    def _check_bare(self, bare: Body) -> Iterator[str]:
        core = bare.core
        density = core.mass / core.volume if core.mass else 0.0
        if density > MAX_DENSITY:
            yield (
                f"the core of {core.mass:g} kg has a radius of {show_length(core.radius)}: {density:.3g} kg/m3, and "
                f"osmium has {MAX_DENSITY:g}; masses are in kg, lengths in m"
            )
        if not 10 <= bare.hull_density <= MAX_DENSITY:
            yield f"the hull's material has {bare.hull_density:g} kg/m3, ABS has 1050: densities are in kg/m3"
        try:
            agent = self.pipeline.realise(Morphology())
        except Exception:
            # A failure of each genome, if it has modules too.
            return
        yield from (f"the smallest body: {line}" for line in list_limits(agent, self.scenario))

    def _check_plane(self) -> Iterator[str]:
        """Check whether all flights stay in one plane by symmetry, and which targets lie off it.

        In the vertical plane through the pipe's axis: a body of revolution that is released in this plane feels no force
        across it, neither from weight, nor from the wall, nor from water that flows alike on both sides.
        """
        scenario, axis = self.scenario, self.scenario.direction()
        if scenario.has_gusts:
            return
        centre = scenario.pipe.layout.inlet.centre
        normal = np.cross(axis, [0.0, 0.0, 1.0])
        name = "the vertical plane through the pipe's axis"
        if np.linalg.norm(normal) < 1e-9:
            # In a vertical pipe the release defines the plane, or no plane but the axis.
            sideways = max(
                (v - (v @ axis) * axis for v in self._released_vectors()), key=lambda v: float(np.linalg.norm(v))
            )
            normal = np.cross(axis, sideways) if np.linalg.norm(sideways) > 1e-9 else np.zeros(3)
            name = "the plane of the pipe's axis and the release"
        length = float(np.linalg.norm(normal))
        normal = normal / length if length > 1e-9 else normal
        if any(abs(float(v @ normal)) > 1e-9 for v in self._released_vectors()):
            return
        missed = {}
        for target, point in scenario.target_points().items():
            offset = np.array(point) - centre
            off = float(offset @ normal if normal.any() else np.linalg.norm(offset - (offset @ axis) * axis))
            if abs(off) > NEGLIGIBLE:
                missed[target] = abs(off)
        if missed:
            place = name if length > 1e-9 else "the pipe's axis"
            yield (
                f"no flight leaves {place}, and {_say_lie(missed)} off it, by up to {show_length(max(missed.values()))}: "
                "release the agent with a yaw (release.yaw_deg), or let gusts turn it (gusts.always = true)"
            )

    def _released_vectors(self) -> list[FloatArray]:
        """What a plane of symmetry must contain: offset of the release from the inlet, the body's axis, its velocity."""
        given = self.scenario.release_velocity()
        offset = self._start - self.scenario.pipe.layout.inlet.centre
        return [offset, self.scenario.release_axis(), *([] if given is None else [given])]

    def _check_drift(self) -> Iterator[str]:
        """Check which targets lie beyond the water that passes the release within the horizon."""
        scenario = self.scenario
        horizon, axis = scenario.flight.horizon, scenario.direction()
        low, high = self._find_drift(horizon)
        off = {name: float((np.array(p) - self._start) @ axis) for name, p in scenario.target_points().items()}
        # A body may be that long, m.
        reach = 0.1
        upstream = {name: s for name, s in off.items() if s < low - reach}
        beyond = {name: s for name, s in off.items() if s > high + reach}
        if not upstream and not beyond:
            return
        if high - low < 1e-9:
            yield (
                f"the water is at rest (flow.speed = {scenario.flow.speed:g} m/s), and {list_targets({**upstream, **beyond})} "
                f"up to {show_length(max(map(abs, off.values())))} along the pipe: set flow.speed"
            )
        elif beyond and high < reach and scenario.flow.speed < 0:
            yield (
                f"the current of {scenario.flow.speed:g} m/s carries an agent away from {list_targets(beyond)}, up to "
                f"{show_length(max(beyond.values()))} along the pipe: make flow.speed positive, or exchange start and "
                "end of the pipe"
            )
        elif beyond:
            farthest = max(beyond.values())
            needed = _find_time(self._find_drift, farthest)
            remedy = "change flow" if needed is None else f"set flight.horizon to more than {needed:.3g} s"
            yield (
                f"the water passes at most {show_length(high)} of the pipe in flight.horizon = {horizon:g} s, and "
                f"{list_targets(beyond)} up to {show_length(farthest)} from the release: {remedy}"
            )
        if upstream and high - low >= 1e-9:
            yield (
                f"{list_targets(upstream)} up to {show_length(-min(upstream.values()))} upstream of the release, and the water "
                f"passes at most {show_length(-low)} in that direction: move release.position, or turn the current"
            )

    def _check_bends(self) -> Iterator[str]:
        for placed in self.scenario.pipe.layout.parts:
            if not isinstance(part := placed.part, Bend):
                continue
            angle, bore = float(np.rad2deg(part.angle)), 2 * part.radius
            if angle < MIN_BEND_DEG:
                yield (
                    f"a bend turns by {angle:.4g} degrees: angle_deg is in degrees, and {angle:.4g} rad are "
                    f"{np.rad2deg(angle):.4g} degrees"
                )
            if part.bend_radius < MIN_BEND_RADIUS * bore * (1 - 1e-9):
                yield (
                    f"a bend has a radius of {show_length(part.bend_radius)}, {part.bend_radius / bore:.2g} times the bore of "
                    f"{show_length(bore)}: elbows have {MIN_BEND_RADIUS:g} times and more; is pipe.radius a diameter?"
                )

    def _check_limits(self) -> Iterator[str]:
        scenario, robustness, layout = self.scenario, self.scenario.robustness, self.scenario.pipe.layout
        radius, horizon = layout.inlet.radius, scenario.flight.horizon
        needed = _find_time(self._find_drift, layout.longest_path)
        if needed is not None and scenario.pipe.straight is None and horizon < needed:
            yield (
                f"flight.horizon = {horizon:g} s is less than the {needed:.3g} s in which the water passes {layout.longest_path:.3g} m "
                "at its speed at the inlet, the distance to the farthest outlet"
            )
        if needed is not None and horizon > PATIENCE * needed:
            yield (
                f"flight.horizon = {horizon:g} s is more than {PATIENCE} times the {needed:.3g} s in which the water passes the "
                "pipe: an agent that comes to rest is simulated that long; it is in seconds"
            )
        if robustness.conditions and robustness.position > 0.5 * radius:
            yield (
                f"robustness.position = {robustness.position:g} m is large in a bore with a radius of {radius:g} m: "
                "it is a standard deviation, in metres"
            )
        drags = [name for name in DRAGS if getattr(scenario.calibration, name) is not None]
        if drags and self.pipeline.hydrodynamics.options.drag == "none":
            yield (
                f"calibration.{drags[0]} has no effect: hydrodynamics.drag is 'none'; set it to 'strips', as in the flights "
                "that were filmed"
            )
        if scenario.contact.friction > 1.5:
            yield (
                f"contact.friction = {scenario.contact.friction:g} is more than rubber on concrete has, about 1: "
                "it is a coefficient, not in percent"
            )

    def _find_drift(self, horizon: float) -> tuple[float, float]:
        """Return how far upstream (<= 0) and downstream of its release an agent can drift along the pipe, m.

        With the fastest water, or with its own speed at the release if that is greater, and as fast as it may rise or
        sink in a pipe that is not level.
        """
        scenario, flow, axis = self.scenario, self.scenario.flow, self.scenario.direction()
        given = scenario.release_velocity()
        speeds = [] if given is None else [float(given @ axis)]
        times, acceleration = [horizon], 0.0
        if isinstance(flow, UniformFlow):
            acceleration = flow.acceleration
            if flow.speed * acceleration < 0:
                times.append(min(horizon, -flow.speed / acceleration))
            speeds.append(flow.speed)
        elif isinstance(flow, PowerLawFlow):
            # Maximum over mean of (y/R)^(1/n): (n + 1) (2 n + 1) / (2 n^2) (Schlichting, Boundary-Layer Theory, ch. XX).
            n = flow.exponent
            speeds.append(flow.speed * (n + 1) * (2 * n + 1) / (2 * n * n))
        elif is_laminar(flow, scenario.pipe.layout.inlet.radius, flow.speed, scenario.fluid.viscosity):
            speeds.append(flow.speed * LAMINAR_SPEED)
        else:
            speeds.append(flow.speed * CENTRE_SPEED)
        own = OWN_SPEED * abs(float(axis[2])) * horizon
        drifts = [0.0, *(speed * t + 0.5 * acceleration * t * t for speed in speeds for t in times)]
        return min(drifts) - own, max(drifts) + own

    def _check_targets(self) -> Iterator[str]:
        points: dict[Any, str] = {}
        for name, point in self.scenario.target_points().items():
            if (other := points.setdefault(point, name)) != name:
                yield f"targets {other} and {name} are the same point: remove one of them"

    def _check_places(self, bare: Body | None) -> Iterator[str]:
        """Check which targets every agent passes, and which none can."""
        points = self.scenario.target_points()
        lengths = [body.length for body in self._random_agents if isinstance(body, Body)]
        if lengths:
            typical = float(np.median(lengths))
            distances = {name: float(np.linalg.norm(point - self._start)) for name, point in points.items()}
            near = {name: distance for name, distance in distances.items() if distance < typical}
            if near:
                yield (
                    f"{_say_lie(near)} {show_length(min(near.values()))} from the release, less than the length of an agent ({show_length(typical)}, the median of random ones): every agent "
                    "passes there; move the target or release.position"
                )
        if bare is None or not points:
            return
        radius = 0.5 * bare.max_diameter
        gaps = dict(zip(points, wall_distance(list(points.values()), self.scenario), strict=True))
        missed = {name: gap for name, gap in gaps.items() if gap < radius - NEGLIGIBLE}
        if missed:
            yield (
                f"{_say_lie(missed)} {show_length(min(missed.values()))} from the wall, and the centre of the smallest body comes no nearer than its radius, {show_length(radius)}: every agent misses "
                f"by {show_length(radius - min(missed.values()))} or more; move the target off the wall"
            )

    @cached_property
    def _random_agents(self) -> list[Body | str]:
        """Bodies of random genomes, or why one cannot be built or released, in one line."""
        rng = np.random.default_rng(0)
        return [self.pipeline.try_build(self.pipeline.grammar.random(rng)) for _ in range(SAMPLED_AGENTS)]

    def _check_random_agents(self) -> Iterator[str]:
        reasons = [found for found in self._random_agents if isinstance(found, str)]
        if len(reasons) > SAMPLED_AGENTS // 4:
            reason, count = find_commonest(reasons)
            yield (
                f"{len(reasons)} of {SAMPLED_AGENTS} random agents cannot be released, {count} of them like this: {reason}"
            )


def _find_time(drift: Callable[[float], tuple[float, float]], distance: float) -> float | None:
    """Return the time (s) in which the water passes ``distance`` (m), by bisection; ``None`` if it never does."""
    low, high = 0.0, 1.0
    while drift(high)[1] < distance:
        low, high = high, 2 * high
        if high > 1e9:
            return None
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if drift(middle)[1] >= distance else (middle, high)
    return high


def _say_lie(names: Collection[str]) -> str:
    return f"{list_targets(names)} {'lies' if len(names) == 1 else 'lie'}"


def list_targets(names: Iterable[str]) -> str:
    """Return targets as words of a sentence; of more than four the first three, and how many more there are."""
    names = list(names)
    if len(names) == 1:
        return f"target {names[0]}"
    shown = names if len(names) <= 4 else [*names[:3], f"{len(names) - 3} more"]
    return f"targets {', '.join(shown[:-1])} and {shown[-1]}"
