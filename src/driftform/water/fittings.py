"""A pipe with parts as one flat array for compiled kernels, built once for each pipe and its flow."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform.util.latest import keep_latest
from driftform.water.flow import Flow, GridFlow, PipeFlow, friction_velocity, is_laminar
from driftform.water.parts import stream
from driftform.water.parts import walls as wall
from driftform.water.parts.grid_flow import load_grid
from driftform.water.parts.layout import Layout, Placed
from driftform.water.parts.rows import open_water_rows, wall_rows
from driftform.water.parts.shapes import Bend, PipePart, Straight, Tee
from driftform.water.parts.tee_flow import tee_field
from driftform.water.pipe import Pipe
from driftform.water.regime import profile_kind, profile_parameter
from driftform.water.scenario import Scenario

CHANGE = 2.0
"""Length in which a straight changes over to the flow of a fitting, in radii of its bore, where it is long enough."""

MIN_PROFILE_LENGTH = 2.0
"""Length of a straight, in radii of its bore, below which it has plug flow like the fittings at its ends."""


def fitting_array(scenario: Scenario) -> FloatArray | None:
    """Return the pipe of a scenario as one flat array; ``None`` for a straight pipe and in open water without a grid.

    A grid of velocities follows the pipe, which may be straight. Open water is then a bore that is wider than any flight.

    Its numbers are explained in :mod:`driftform.water.parts.walls` and :mod:`driftform.water.parts.stream`.
    """
    if isinstance(scenario.flow, GridFlow):
        return load_grid(scenario.flow.file, scenario.flow.reference, scenario.pipe.layout, _grid_walls(scenario))
    if scenario.pipe.is_open or scenario.pipe.straight is not None:
        return None
    return _make_array(scenario.pipe, scenario.flow, scenario.fluid.viscosity)


def _grid_walls(scenario: Scenario) -> FloatArray:
    """Return the array of a pipe with the friction of its walls at the speed of the file of a grid."""
    pipe, flow, values = scenario.pipe, scenario.flow, wall_array(scenario.pipe).copy()
    assert isinstance(flow, GridFlow)
    rows = values[wall.HEAD :].reshape(-1, wall.PART)
    for row, speed in zip(rows, [] if pipe.is_open else _list_speeds(rows, pipe.layout, flow.reference), strict=False):
        _set_friction(row, flow, speed, scenario.fluid.viscosity)
    return values


@lru_cache(maxsize=16)
def _make_array(pipe: Pipe, flow: Flow, viscosity: float) -> FloatArray:
    rows = wall_rows(pipe.layout)
    fields = _fill_flow(rows, pipe.layout, flow, viscosity)
    values = np.concatenate([[float(len(rows))], rows.ravel(), *fields])
    values.flags.writeable = False
    return values


@keep_latest
@lru_cache(maxsize=16)
def wall_array(pipe: Pipe) -> FloatArray:
    """Return the array of a pipe without its flow, read-only; of open water, of a bore without end."""
    rows = wall_rows(pipe.layout) if not pipe.is_open else open_water_rows()
    return np.concatenate([[float(len(rows))], rows.ravel()])


@dataclass(frozen=True)
class _Joint:
    """The flow at one end of a straight or a bend: ``vortex`` is that of the bend beyond it, with its share."""

    is_plug: bool
    vortex: Bend | None = None
    share: float = 0.0


def _fill_flow(rows: FloatArray, layout: Layout, flow: Flow, viscosity: float) -> list[FloatArray]:
    """Write the flow of all parts to their rows; return the fields of the tees, which follow the rows."""
    fields: list[FloatArray] = []
    place = wall.HEAD + rows.size
    parts = [placed.part for placed in layout.parts]
    ahead: dict[int, int] = {
        p.upstream: k for k, p in enumerate(layout.parts) if p.upstream is not None and not p.by_branch
    }
    shares = [_vortex_share(layout, ahead, k) for k in range(len(parts))]
    speeds = _list_speeds(rows, layout, flow.speed)
    for row, speed in zip(rows, speeds, strict=True):
        row[stream.SPEED] = speed
        _set_friction(row, flow, speed, viscosity)
    for k, (placed, row, speed) in enumerate(zip(layout.parts, rows, speeds, strict=False)):
        match placed.part:
            case Tee():
                field = _make_field(placed, speed)
                row[wall.FIELD], row[wall.FIELD_SIZE] = place, len(field)
                fields.append(field)
                place += len(field)
            case Straight():
                ends = _neighbours(layout, ahead, k)
                _fill_straight(row, placed.part, flow, viscosity, [_joint(parts, shares, end) for end in ends])
                if ends[0] is not None and _carries_profile(placed.part):
                    row[stream.SWIRL] = _find_swirl(flow, parts[ends[0]])
            case Bend():
                row[stream.STRENGTH] = shares[k]
                following = ahead.get(k)
                decays = following is not None and _carries_profile(parts[following])
                row[stream.SWIRL] = (1 if decays else -1) * _find_swirl(flow, placed.part)
                for start, end in zip((stream.START, stream.FINISH), _neighbours(layout, ahead, k), strict=True):
                    if end is None or not _joins_smoothly(placed.part, parts[end]):
                        row[start + stream.LONG] = min(
                            CHANGE * placed.part.radius / placed.part.bend_radius, 0.5 * placed.part.angle
                        )
    beyond, nothing = len(parts), _joint(parts, shares, None)
    straight = Straight(
        rows[beyond, wall.ORIGIN : wall.ORIGIN + 3], layout.inlet.axes, layout.inlet.radius, rows[beyond, wall.LENGTH]
    )
    _fill_straight(rows[beyond], straight, flow, viscosity, [nothing, _joint(parts, shares, 0)])
    for number, outlet in enumerate(layout.outlets):
        row, opening = rows[beyond + 1 + number], outlet.opening
        straight = Straight(opening.centre, opening.axes, opening.radius, row[wall.LENGTH])
        _fill_straight(row, straight, flow, viscosity, [_joint(parts, shares, outlet.part), nothing])
    return fields


def _find_swirl(flow: Flow, part: PipePart) -> float:
    """Return the secondary flow that a bend leaves, over the mean speed: as its angle, up to a right angle."""
    if not isinstance(flow, PipeFlow) or not isinstance(part, Bend):
        return 0.0
    return flow.swirl * min(1.0, part.angle / (0.5 * math.pi))


def _list_speeds(rows: FloatArray, layout: Layout, inlet: float) -> list[float]:
    """Return the mean speed (m/s) at the entry of each row's part, at the mean speed ``inlet``."""
    parts, radius = [placed.part for placed in layout.parts], layout.inlet.radius
    speeds = [inlet * placed.flow * (radius / placed.part.radius) ** 2 for placed in layout.parts]
    beyond = [inlet]
    for outlet in layout.outlets:
        part = parts[outlet.part]
        share = 1 - part.share if isinstance(part, Tee) else 1.0
        beyond.append(speeds[outlet.part] * (part.radius / part.end_radius) ** 2 * share)
    return [*speeds, *beyond]


def _set_friction(row: FloatArray, flow: Flow, speed: float, viscosity: float) -> None:
    """Write the friction velocity to a row; a laminar flow has none that matters, since it has no gusts."""
    radius = row[wall.RADIUS]
    turbulent = not is_laminar(flow, radius, speed, viscosity)
    row[stream.FRICTION] = friction_velocity(flow, radius, abs(speed), viscosity) if turbulent else 0.0


def _make_field(placed: Placed, speed: float) -> FloatArray:
    """Return the flow in a tee that the water enters at the mean ``speed`` (m/s)."""
    tee = placed.part
    assert isinstance(tee, Tee)
    flux = speed * math.pi * tee.radius**2
    through, side = (1 - tee.share) * flux, tee.share * flux
    try:
        return tee_field(tee.radius, tee.branch_radius, tee.angle, tee.fillet, through, side)
    except ValueError as error:
        raise InputError(f"{placed.key}: {error}") from None


def _neighbours(layout: Layout, ahead: Mapping[int, int], k: int) -> tuple[int | None, int | None]:
    """Return the parts before and after a part, None beyond the inlet and the outlets."""
    return layout.parts[k].upstream, ahead.get(k)


def _carries_profile(part: PipePart) -> bool:
    return isinstance(part, Straight) and part.straight >= MIN_PROFILE_LENGTH * part.radius


def _joins_smoothly(bend: Bend, other: PipePart) -> bool:
    """Return whether the vortex of a bend needs no change within the bend at its end."""
    if isinstance(other, Bend):
        return bool(other.bend_radius == bend.bend_radius and np.allclose(bend.axes[1], other.axes[1], atol=1e-9))
    return _carries_profile(other)


def _vortex_share(layout: Layout, ahead: Mapping[int, int], k: int) -> float:
    """Return how much of the free vortex a bend has: all of it, unless it must come and go within a short bend."""
    part = layout.parts[k].part
    if not isinstance(part, Bend):
        return 0.0
    ends = _neighbours(layout, ahead, k)
    changes = sum(end is not None and not _joins_smoothly(part, layout.parts[end].part) for end in ends)
    return min(1.0, part.length / (changes * part.radius)) if changes else 1.0


def _joint(parts: Sequence[PipePart], shares: Sequence[float], end: int | None) -> _Joint:
    """Return the flow at an end of a straight that carries the profile, as the part beyond it has it."""
    if end is None or _carries_profile(parts[end]):
        return _Joint(False)
    part = parts[end]
    return _Joint(True, part, shares[end]) if isinstance(part, Bend) else _Joint(True)


def _fill_straight(row: FloatArray, part: Straight, flow: Flow, viscosity: float, joints: Sequence[_Joint]) -> None:
    if not _carries_profile(part):
        return
    speed = abs(row[stream.SPEED])
    row[stream.PROFILE] = profile_kind(flow, part.radius, speed, viscosity)
    row[stream.DEVELOPED], row[stream.PARAMETER] = (1.0, profile_parameter(flow, part.radius, speed, viscosity))
    for start, joint in zip((stream.START, stream.FINISH), joints, strict=True):
        if joint.is_plug:
            row[start + stream.LONG] = min(CHANGE * part.radius, 0.5 * part.straight)
        if joint.vortex is not None:
            # At either end of a bend, its centre lies in the direction of its own z there.
            bend = joint.vortex
            at_entry = np.allclose(
                bend.origin, part.origin + (part.straight if start == stream.FINISH else 0.0) * part.axes[0]
            )
            inward = bend.axes[2] if at_entry else bend.list_exits()[0].axes[2]
            row[start + stream.AMPLITUDE], row[start + stream.AROUND] = joint.share, bend.bend_radius
            row[start + stream.TOWARD_Y], row[start + stream.TOWARD_Z] = (part.axes[1] @ inward, part.axes[2] @ inward)
