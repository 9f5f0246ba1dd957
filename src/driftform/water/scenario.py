"""The tables of a scenario: pipe, flow, fluid, release, contact, targets. Validated here, read by kernels as arrays."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag, ValidationError, model_validator

from driftform.errors import did_you_mean
from driftform.types import Body, FloatArray, MassProperties, Trajectory
from driftform.util.latest import keep_latest
from driftform.util.options import Table, describe, find_table, option
from driftform.water.factors import Calibration
from driftform.water.flow import (
    FLOWS,
    DevelopingFlow,
    Flow,
    Gusts,
    PipeFlow,
    RoughFlow,
    TurbulentFlow,
    UniformFlow,
    friction_velocity,
    is_laminar,
)
from driftform.water.fluids import FLUIDS, find_water_density
from driftform.water.parts.shapes import VERTICAL, upright_axes
from driftform.water.pipe import Pipe, Vector
from driftform.water.places import find_nearest_inside, resolve_place
from driftform.water.wetted import find_surface_fault

_WATERS = (950.0, 1060.0)
"""Densities of fluids that are taken to be water, fresh or salt, kg/m3."""


class Fluid(Table):
    """The water, or another fluid."""

    name: Literal["", "fresh-water", "seawater", "brine", "oil", "methane-60bar", "slurry"] = option(
        "", "fluid whose density, viscosity and expansion replace those given here"
    )
    density: float = option(1024.0, "density of the water", "kg/m3", ge=0.1, le=30_000)
    expansion: float = option(
        2.57e-4, "thermal expansion of its volume; the default is that of seawater at 20 degrees C", "1/K", ge=0, le=0.1
    )
    celsius: float = option(20.0, "temperature at which it has these", "degrees C", ge=-10, le=100)
    gravity: float = option(9.81, "acceleration of gravity, along -z", "m/s2", ge=0, le=1000)
    viscosity: float = option(
        1.05e-6, "kinematic viscosity; the default is seawater at 20 degrees C", "m2/s", ge=1e-8, le=1
    )
    water_level: float | None = option(
        None,
        "height of the free surface in the world frame; by default the pipe is full",
        "m",
        ge=-1e6,
        le=1e6,
        strict=True,
    )
    flow_force: Literal["full", "paper"] = option(
        "full", "force of accelerating water: full with its pressure gradient (Froude-Krylov), or paper without it"
    )

    @model_validator(mode="before")
    @classmethod
    def _take_named(cls, values: Any) -> Any:
        named = FLUIDS.get(values.get("name", "")) if isinstance(values, dict) else None
        if named is None:
            return values
        return values | {key: getattr(named, key) for key in ("density", "viscosity", "expansion", "celsius")}

    def density_at(self, celsius: float) -> float:
        """Return its density (kg/m3) at another temperature: linear, and for water with the curvature of pure water.

        Salt changes the slope, which ``expansion`` has, and the curvature by little.
        """
        warmer = celsius - self.celsius
        linear = self.density * (1 - self.expansion * warmer)
        if not (_WATERS[0] <= self.density <= _WATERS[1] and min(celsius, self.celsius) >= 0):
            return linear
        here, step = find_water_density(self.celsius), 1e-3
        slope = (find_water_density(self.celsius + step) - here) / step
        return linear + find_water_density(celsius) - here - slope * warmer


class Release(Table):
    """How the agent enters the water: position, attitude and velocity in one ``frame``.

    The frame of the inlet has its origin at the inlet's centre, x downstream along the pipe, y level, and z upward, or
    upstream of a vertical pipe's x for lack of an upward direction.
    """

    frame: Literal["inlet", "world"] = option(
        "inlet", "frame of the release: inlet, at its centre with x along the pipe, or world"
    )
    position: Vector = option(
        (0.0, 0.0, 0.0),
        "position of the core's centre at the release; or a place in the pipe, as targets may have it",
        "m",
    )
    pitch_deg: float = option(0.0, "pitch of the body's axis relative to x, positive nose down", "deg", ge=-90, le=90)
    yaw_deg: float = option(0.0, "yaw of the body's axis relative to x, positive towards +y", "deg", ge=-180, le=180)
    roll_deg: float = option(0.0, "roll about the body's axis", "deg", ge=-180, le=180)
    rates: Vector = option((0.0, 0.0, 0.0), "rates of roll, pitch and yaw, about the body's own axes", "rad/s")
    velocity: Literal["current", "rest"] | Vector = option(
        "current", "'current' (moving with the water), 'rest', or a velocity", "m/s"
    )
    port: float = option(
        0.0,
        "diameter that passes what the agent is put in by, such as a valve; a wider body is infeasible; 0: no limit",
        "m",
        ge=0,
        le=100,
    )
    ballast: float = option(
        0.0, "mass that hangs on the agent's outside, such as a sinker on a tape", "kg", ge=0, le=1e4
    )
    ballast_x: float = option(
        0.0, "where along the axis it hangs, from the core's centre, fore positive", "m", ge=-100, le=100
    )
    ballast_density: float = option(11_340.0, "density of the ballast; the default is lead", "kg/m3", ge=100, le=30_000)

    def load(self, mass: MassProperties) -> MassProperties:
        """Return the mass properties with the ballast on the outside of the agent, in its water.

        The ballast is a point on the axis. It displaces water of its own volume; its drag is neglected.
        """
        if self.ballast == 0.0:
            return mass
        volume, offset = self.ballast / self.ballast_density, np.array([self.ballast_x, 0.0, 0.0])
        total, displaced = mass.mass + self.ballast, mass.volume + volume
        cog = (mass.mass * mass.cog + self.ballast * offset) / total
        cob = (mass.volume * mass.cob + volume * offset) / displaced
        across = np.diag([0.0, 1.0, 1.0])
        inertia = mass.inertia + mass.mass * (mass.cog[0] - cog[0]) ** 2 * across
        inertia = inertia + self.ballast * (self.ballast_x - cog[0]) ** 2 * across
        return MassProperties(total, cog, inertia, displaced, cob)


class Contact(Table):
    """Contact with the pipe's wall: stiff springs, dampers set by the restitution, and Coulomb friction.

    The stiffness of a spring is such that the mass that moves with it, added mass included, oscillates on it at
    ``frequency``. A collision returns the share ``restitution`` exp(-35 / St) of the speed along the wall's normal, with
    the Stokes number St of the impact.
    """

    frequency: float = option(
        300.0, "angular frequency of the body on the spring of one contact", "rad/s", ge=50, le=1e4
    )
    restitution: float = option(0.25, "coefficient of restitution in air", "", ge=0.1, le=1)
    friction: float = option(0.0, "coefficient of Coulomb friction", "", ge=0, le=10)


class FlightLimits(Table):
    """Limits of a flight that does not reach the outlet."""

    horizon: float = option(20.0, "longest duration of a flight", "s", ge=1e-6, le=1e5)


class Robustness(Table):
    """Disturbed conditions: how the best agents are chosen, and how their promises are made.

    The quantities are standard deviations of normal distributions, truncated at three standard deviations.
    """

    conditions: int = option(
        20,
        "disturbed flights of each finalist that can still win, by which the best is chosen; 0 to choose by the undisturbed "
        "flight alone",
        ge=0,
        le=10_000,
    )
    within: Annotated[float, Field(gt=0, le=1000)] | dict[str, Annotated[float, Field(gt=0, le=1000)]] | None = option(
        None,
        "how near a flight must pass a target to hit it, for all targets or by the name of each; by default 5 % of the "
        "farthest distance, and at most half the radius of the bore",
        "m",
    )
    weighed: bool = option(
        True,
        "search and choose by prints that are weighed in water and trimmed, so that the errors of mass, wall and outside do not count",
    )
    survey: int = option(
        8,
        "disturbed flights, among those of the choice, of each agent that may be among the best of the search, at most; its "
        "search score is the mean fitness of these and of the undisturbed flight; agents that fall behind are dropped",
        ge=0,
        le=10_000,
    )
    finalists: int = option(
        4,
        "finalists for each target: top agents by search score, of those that come near it undisturbed if any do",
        gt=0,
        le=10_000,
    )
    score: Literal["mean", "quantile", "worst"] = option(
        "quantile", "score of a finalist, from its fitness over all conditions"
    )
    quantile: float = option(
        0.1, "share of the conditions with a fitness below the score, if score = 'quantile'", ge=0, le=1
    )
    checks: int = option(
        40,
        "disturbed flights of each best agent under conditions of their own, from which its median and 90 % miss come",
        ge=1,
        le=10_000,
    )
    gusts: bool = option(
        True, "gusts in disturbed flights, as [gusts] describes them, if the flow is developed and turbulent"
    )
    gust_strength: float = option(
        0.2, "standard deviation of `gusts.strength` in disturbed flights with gusts, relative to it", ge=0, le=0.3
    )
    gust_memory: float = option(0.25, "standard deviation of `gusts.memory`, relative to it; the same", ge=0, le=0.3)
    gust_crossing: float = option(0.3, "standard deviation of `gusts.crossing`, relative to it; the same", ge=0, le=0.3)
    swirl: float = option(
        0.1,
        "standard deviation of `flow.swirl`, the secondary flow in and after bends, which is never negative; ideal flow has "
        "0.2 to 0.3 after 90 degrees (Squire and Winter 1951)",
        ge=0,
        le=0.16,
    )
    position: float = option(
        0.02, "standard deviation of the release position in each direction across the pipe", "m", ge=0, le=10
    )
    angle_deg: float = option(2.0, "standard deviation of pitch and yaw at the release", "deg", ge=0, le=30)
    current: float = option(0.03, "standard deviation of the speed of the current, relative to it", ge=0, le=0.3)
    density: float = option(0.001, "standard deviation of the density of the water, relative to it", ge=0, le=0.3)
    mass: float = option(0.01, "standard deviation of the mass of the printed hull, relative to it", ge=0, le=0.3)
    wall: float = option(0.00002, "standard deviation of the thickness of the printed wall", "m", ge=0, le=0.01)
    outside: float = option(
        0.00005, "standard deviation of the offset of the printed outer surface along its normal", "m", ge=0, le=0.01
    )
    shrinkage: float = option(
        0.001, "standard deviation of the linear scale of the print, relative to it", ge=0, le=0.1
    )
    temperature: float = option(
        5.0, "standard deviation of the difference of temperature between trimming and flight", "K", ge=0, le=50
    )
    absorbed: float = option(
        0.001,
        "standard deviation of the water that the hull takes up after it was weighed, relative to its mass",
        ge=0,
        le=0.3,
    )
    bubble: float = option(
        1e-7, "standard deviation of the volume of the bubbles that cling to it, of air", "m3", ge=0, le=0.001
    )
    drag: float = option(0.2, "standard deviation of drag and damping, relative to them", ge=0, le=0.3)


Target: TypeAlias = Annotated[
    Annotated[Vector, Tag("point")] | Annotated[str, Tag("outlet")],
    Discriminator(lambda value: "outlet" if isinstance(value, str) else "point"),
]
"""A point in the world frame, or the name of an outlet, whose centre is the point."""


def _check_names(targets: dict[str, Target]) -> dict[str, Target]:
    for name in targets:
        if not name.replace("-", "").replace("_", "").isalnum():
            raise ValueError(f"target name '{name}' must consist of letters, digits, '-' and '_': it names a folder")
    return targets


class Scenario(Table):
    """The whole environment; the same tables as in a study file."""

    pipe: Pipe = Field(default=Pipe(), description="the pipe")
    flow: Flow = Field(default=UniformFlow(), description="the current")
    gusts: Gusts = Field(default=Gusts(), description="the turbulence of a developed flow in a pipe")
    fluid: Fluid = Field(default=Fluid(), description="the water")
    release: Release = Field(default=Release(), description="how the agent enters the water")
    contact: Contact = Field(default=Contact(), description="contact with the wall")
    flight: FlightLimits = Field(default=FlightLimits(), description="limits of a flight")
    robustness: Robustness = Field(
        default=Robustness(), description="disturbances of the finalists' flights, and their score"
    )
    calibration: Calibration = Field(default=Calibration(), description="factors on the model, from filmed flights")
    targets: Annotated[dict[str, Target], AfterValidator(_check_names)] = Field(
        default={},
        max_length=1000,
        description="points to reach: name and position in the world frame, or the name of an outlet",
        json_schema_extra={"unit": "m"},
    )

    @staticmethod
    def describe_flows() -> dict[str, list[dict[str, Any]]]:
        """Return the options of each kind of current: rows ``{option, type, bounds, default, unit, help}``."""
        return {kind: describe(model) for kind, model in FLOWS.items()}

    @classmethod
    def describe_tables(cls) -> dict[str, list[dict[str, Any]]]:
        """Return the options of each table that is of one kind, such as ``fluid``; rows as :meth:`describe_flows` has them."""
        tables = {name: find_table(field.annotation) for name, field in cls.model_fields.items()}
        return {name: describe(table) for name, table in tables.items() if table is not None}

    @model_validator(mode="before")
    @classmethod
    def _find_places(cls, values: Any) -> Any:
        """Replace targets, and a release, that name a place in the pipe by its coordinates."""
        found: dict[str, dict[str, Any]] = {}
        for table in ("targets", "release") if isinstance(values, Mapping) else ():
            rows = values.get(table)
            if not isinstance(rows, Mapping) or not any(isinstance(v, Mapping) for v in rows.values()):
                continue
            try:
                layout = Pipe.model_validate(values.get("pipe", {})).layout
            except ValidationError:
                # The errors of the pipe are enough; places in it can be judged when it is right.
                return {key: value for key, value in values.items() if key not in ("targets", "release")}
            for name, value in rows.items():
                try:
                    found.setdefault(table, {})[name] = resolve_place(value, layout)
                except ValueError as error:
                    raise ValueError(f"{table}.{name}: {error}") from None
            if isinstance(rows.get("position"), Mapping) and table == "release" and rows.get("frame") != "world":
                inlet, point = layout.inlet, np.array(found[table]["position"])
                found[table]["position"] = (upright_axes(inlet.axes[0]) @ (point - inlet.centre)).tolist()
        return {**values, **found} if found else values

    @model_validator(mode="after")
    def _check_together(self) -> "Scenario":
        if self.targets and self.pipe.is_open:
            raise ValueError("targets need a pipe: fitness is relative to the farthest point of its volume")
        if isinstance(self.flow, PipeFlow) and self.pipe.is_open:
            raise ValueError(
                f"flow.kind = '{self.flow.kind}' needs a pipe; in open water it must be 'uniform' or 'grid'"
            )
        if isinstance(self.flow, RoughFlow):
            most = 0.1 * self.pipe.layout.narrowest
            if self.flow.roughness > most:
                raise ValueError(
                    f"flow.roughness = {self.flow.roughness} is too large for the logarithmic law in this pipe: "
                    f"it is valid up to a twentieth of the diameter, {most:g} m"
                )
        if self.pipe.is_open:
            return self
        level = self.fluid.water_level
        if level is not None and (fault := find_surface_fault(self.pipe, self.flow, level)) is not None:
            raise ValueError(f"fluid.water_level = {level:g} {fault} (leave fluid.water_level out)")
        if self.pipe.straight is None:
            _check_flow_in_parts(self.flow)
        if faults := list(self._find_outside()):
            # Nobody reads the tenth.
            if len(faults) > 3:
                faults = [faults[0], f"{faults[1]}; and {len(faults) - 2} more"]
            raise ValueError(*faults)
        return self

    def _find_outside(self) -> Iterator[str]:
        start = self.release_position()
        if not self.pipe.contains((start[0], start[1], start[2])):
            where = "" if self.release.frame == "world" else " (it is relative to the inlet: see release.frame)"
            yield f"release.position = {list(self.release.position)} lies outside the pipe{where}"
        within = self.robustness.within
        for name in within if isinstance(within, dict) else ():
            if name not in self.targets:
                yield f"robustness.within.{name}: no such target{did_you_mean(name, self.targets)}"
        outlets = {outlet.name: outlet.opening.centre for outlet in self.pipe.layout.outlets}
        for name, target in self.targets.items():
            if isinstance(target, str):
                if target not in outlets:
                    yield f"targets.{name} = '{target}': the pipe has no such outlet{did_you_mean(target, outlets)}"
            elif not self.pipe.contains(target):
                nearest, away = find_nearest_inside(np.array(target), self.pipe.layout)
                inside = ", ".join(f"{x:.4g}" for x in nearest)
                yield (
                    f"targets.{name} = {list(target)} lies outside the pipe, {away:.3g} m from it; the nearest point "
                    f"inside is [{inside}]"
                )

    @property
    def target_names(self) -> tuple[str, ...]:
        """Names of the targets, in the order of every fitness vector."""
        return tuple(self.targets)

    def target_points(self) -> dict[str, Vector]:
        """Return the positions of the targets in the world frame, m, by name; of an outlet, its centre."""
        openings = {outlet.name: outlet.opening for outlet in self.pipe.layout.outlets}
        points: dict[str, Vector] = {}
        for name, target in self.targets.items():
            if isinstance(target, str):
                x, y, z = openings[target].centre.tolist()
                points[name] = (x, y, z)
            else:
                points[name] = target
        return points

    @keep_latest
    def target_array(self) -> FloatArray:
        """Return the positions of the targets in the world frame, m, (targets, 3)."""
        return np.array(list(self.target_points().values()), dtype=np.float64).reshape(-1, 3)

    def direction(self) -> FloatArray:
        """Return the unit vector downstream at the inlet, in the world frame, (3,); along x in open water."""
        if self.pipe.is_open:
            return np.array([1.0, 0.0, 0.0])
        return np.asarray(self.pipe.layout.inlet.axes[0])

    def current(self) -> FloatArray:
        """Return the mean velocity of the water at the inlet, in the world frame, m/s, (3,)."""
        current = self.flow.speed * self.direction()
        return current + self.flow.added if isinstance(self.flow, UniformFlow) else current

    @property
    def can_have_gusts(self) -> bool:
        """True if the flow of the pipe is developed and turbulent somewhere, and gusts have any strength."""
        if self.pipe.is_open or isinstance(self.flow, UniformFlow | DevelopingFlow) or not self.gusts.strength:
            return False
        radius = self.pipe.layout.inlet.radius
        straight = self.pipe.straight is not None
        return not (straight and is_laminar(self.flow, radius, self.flow.speed, self.fluid.viscosity))

    @property
    def has_gusts(self) -> bool:
        """True if every flight has gusts."""
        return (self.gusts.always or isinstance(self.flow, TurbulentFlow)) and self.can_have_gusts

    def friction_velocity(self) -> float:
        """Return the friction velocity u* = U sqrt(f / 8) of the pipe's wall at the inlet, m/s."""
        radius, viscosity = self.pipe.layout.inlet.radius, self.fluid.viscosity
        return friction_velocity(self.flow, radius, abs(self.flow.speed), viscosity)

    def calibrated_contact(self) -> Contact:
        """Return the contact with the coefficients that filmed flights have shown."""
        factors = self.calibration.factors
        if factors.restitution == factors.friction == 1.0:
            return self.contact
        return self.contact.model_copy(
            update={
                "restitution": factors.scale_restitution(self.contact.restitution),
                "friction": factors.friction * self.contact.friction,
            }
        )

    def of_evaluation(self, seed: int, index: int) -> "Scenario":
        """Return the scenario of evaluation ``index`` of a run with this seed, with the gusts of that evaluation."""
        return self.with_gusts(evaluation_seed(seed, index))

    def with_gusts(self, seed: int | None) -> "Scenario":
        """Return the scenario with the gusts of ``seed``; unchanged if ``seed`` is ``None`` or flights have no gusts."""
        if seed is None or not self.has_gusts:
            return self
        return self.model_copy(update={"gusts": self.gusts.model_copy(update={"seed": seed})})

    def release_frame(self) -> FloatArray:
        """Return the axes of the release's frame in the world frame, as columns, (3, 3)."""
        c, s, cp, sp = self._frame_angles()
        return np.array([[c * cp, -s, c * sp], [s * cp, c, s * sp], [-sp, 0.0, cp]])

    @keep_latest
    def release_position(self) -> FloatArray:
        """Return the position of the core's centre at the release, in the world frame, m, (3,)."""
        start = np.zeros(3) if self._released_in_world else self.pipe.layout.inlet.centre
        return np.asarray(start + self.release_frame() @ self.release.position)

    @keep_latest
    def release_quaternion(self) -> FloatArray:
        """Return the attitude at the release, from body to world, (4,).

        In the frame of the release it is a rotation about x by the roll, about y by the pitch, then about z by the yaw.
        """
        release = self.release
        roll, pitch, yaw = np.deg2rad([release.roll_deg, release.pitch_deg, release.yaw_deg]) / 2
        given = _turn_by(np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch))
        given = _multiply(given, np.array([np.cos(roll), np.sin(roll), 0.0, 0.0]))
        c, s, cp, sp = self._frame_angles()
        frame = _turn_by(*_halve_angle(c, s), *_halve_angle(cp, sp))
        return _multiply(frame, given)

    def find_misfit(self, body: Body) -> str | None:
        """Return why a body cannot be released here, in one line with the two numbers; ``None`` if it can."""
        from driftform.water.misfit import find_misfit

        return find_misfit(body, self)

    @keep_latest
    def release_axis(self) -> FloatArray:
        """Return the unit vector along the body's axis at the release, in the world frame, (3,)."""
        w, x, y, z = self.release_quaternion()
        return np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])

    def release_velocity(self) -> FloatArray | None:
        """Return the velocity at the release, in the world frame, m/s, (3,); ``None`` for the velocity of the water."""
        match self.release.velocity:
            case "current":
                return None
            case "rest":
                return np.zeros(3)
            case given:
                return np.asarray(self.release_frame() @ given)

    def resume(self, flown: Trajectory, duration: float) -> "Scenario":
        """Return the scenario of the next ``duration`` (s) of a flight: an agent is released as it is at the end of ``flown``."""
        # It loads the compiler, which takes longer to import than all else of a scenario.
        from driftform.util import rotations

        R, velocity = rotations.matrix_from_quaternion(flown.quaternion[-1]), flown.velocity[-1]
        release = self.release.model_copy(
            update={
                "frame": "world",
                "position": tuple(flown.position[-1].tolist()),
                "roll_deg": math.degrees(math.atan2(R[2, 1], R[2, 2])),
                "pitch_deg": math.degrees(math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))),
                "yaw_deg": math.degrees(math.atan2(R[1, 0], R[0, 0])),
                "velocity": tuple((R @ velocity[:3]).tolist()),
                "rates": tuple(velocity[3:].tolist()),
            }
        )
        update: dict[str, Any] = {"release": release, "flight": FlightLimits.model_construct(horizon=duration)}
        if isinstance(self.flow, UniformFlow) and self.flow.acceleration:
            speed = self.flow.speed + self.flow.acceleration * float(flown.t[-1])
            update["flow"] = self.flow.model_copy(update={"speed": speed})
        return self.model_copy(update=update)

    @property
    def _released_in_world(self) -> bool:
        """True if the release is given in the world frame; in open water there is no other."""
        return self.release.frame == "world" or self.pipe.is_open

    def _frame_angles(self) -> tuple[float, float, float, float]:
        """Return cosine and sine of the yaw, then of the pitch, of the release's frame."""
        if self._released_in_world:
            return 1.0, 0.0, 1.0, 0.0
        x, y, z = self.direction().tolist()
        level = float(np.hypot(x, y))
        # A vertical pipe has no yaw.
        return (x / level, y / level, level, -z) if level > VERTICAL else (1.0, 0.0, 0.0, math.copysign(1.0, -z))


def _check_flow_in_parts(flow: Flow) -> None:
    """Check that a flow is possible in a pipe with parts."""
    if isinstance(flow, DevelopingFlow):
        raise ValueError(
            "flow.kind = 'developing' is the flow after the inlet of a straight pipe: take 'log_law' in a pipe with parts"
        )
    if isinstance(flow, UniformFlow) and any(flow.added) and flow.speed:
        raise ValueError("flow.added in a pipe with parts is the whole current: set flow.speed = 0")
    if isinstance(flow, UniformFlow) and flow.acceleration:
        raise ValueError("flow.acceleration is for a straight pipe: leave it out in a pipe with parts")
    if flow.speed < 0:
        raise ValueError(
            f"flow.speed = {flow.speed:g}: the water of a pipe with parts flows from the inlet to the outlets"
        )


def _halve_angle(c: float, s: float) -> tuple[float, float]:
    """Return cosine and sine of half an angle of that cosine and sine, exact for multiples of 180 degrees."""
    return float(np.sqrt(max(0.0, 1 + c) / 2)), float(np.copysign(np.sqrt(max(0.0, 1 - c) / 2), s))


def _turn_by(cz: float, sz: float, cy: float, sy: float) -> FloatArray:
    """Return the quaternion of a rotation about y, then about z, from cosine and sine of half of each angle, (4,)."""
    return np.array([cz * cy, -sz * sy, cz * sy, sz * cy])


def _multiply(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the product of two quaternions, (4,): the rotation ``b``, then ``a``."""
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *vector])


def evaluation_seed(seed: int, index: int) -> int:
    """Return the seed of the gusts of evaluation ``index`` of a run with this seed."""
    return int(np.random.SeedSequence((seed, index)).generate_state(1)[0])
