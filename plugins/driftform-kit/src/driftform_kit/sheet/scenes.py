"""The drawing of each step of an assembly: what is in place, and what is added from which side."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from driftform.figures import style
from driftform.types import FloatArray
from driftform_frusta.colours import colour_of
from driftform_kit.cutting.meridian import Hull, Ring
from driftform_kit.sheet.contents import Sheet, SheetPart

CORE, BALLAST, WATER = style.tint(style.ORANGE, 0.6), style.tint(style.INK, 0.5), style.tint(style.BLUE, 0.25)
_PALE = style.tint(style.INK, 0.12)

_HEAD = 6.0
"""Longest head of an arrow, mm of the agent."""

_CIRCLE = np.exp(2j * np.pi * np.arange(48) / 48).view(float).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class Shape:
    """Polygons, or lines without ``fill``, of points in mm, x to the right and y up; or a ``mark`` at the first of them."""

    lines: Sequence[FloatArray]
    fill: str = "none"
    width: float = 0.7
    dash: str = ""
    mark: str = ""
    colour: str = style.INK


def place_scene(sheet: Sheet, step: str, place: FloatArray) -> list[Shape]:
    """Return the shapes of a step, by its key, as large as fits between two corners of a place, (2, 2); in px."""
    shapes = list(_list_shapes(sheet, step))
    points = np.concatenate([line for shape in shapes for line in shape.lines])
    low, high = points.min(axis=0), points.max(axis=0)
    scale, middle = float((np.ptp(place, axis=0) / (high - low)).min()), place.mean(axis=0)
    return [
        replace(shape, lines=[middle + scale * (line - (low + high) / 2) * (1.0, -1.0) for line in shape.lines])
        for shape in shapes
    ]


def _list_shapes(sheet: Sheet, step: str) -> Iterator[Shape]:
    kind, _, which = step.partition(" ")
    hull, parts, first = sheet.kit.hull, sheet.parts, sheet.parts[0]
    wide, length = 2 * hull.widest, float(np.ptp(hull.skin[:, 0]))
    ball = next((ball for ball in sheet.balls if ball.mark == which), None)
    if kind in ("print", "test", "weigh"):
        x = 0.0
        for part in parts:
            yield from _stand(part, x + part.size[0] / 2)
            x += part.size[0] + wide / 4
        yield _draw_floor(-wide / 4, x)
    elif kind == "pause" and ball is not None and ball.pause is not None:
        yield from _stand(parts[ball.number - 1], 0.0)
        yield Shape([np.array([[-wide, ball.pause], [wide, ball.pause]])], dash="4 2")
        yield _draw_ball(0.0, ball.pause - ball.held.ball.radius, ball.held.ball.radius, BALLAST)
        yield from _draw_arrow((0.0, ball.pause + wide), (0.0, ball.pause + wide / 8))
        yield _draw_floor(-wide, wide)
    elif kind == "trim":
        yield from _lay(sheet, parts, loaded=False)
    elif kind in ("insert", "core"):
        part, z, radius, side = first, 0.0, hull.reach, 1.0 if first.place < parts[1].place else -1.0
        if ball is not None and ball.mouth is not None:
            part, z, radius = parts[ball.number - 1], ball.held.ball.z, ball.held.ball.radius
            side = 1.0 if ball.mouth.z > z else -1.0
        yield from _lay(sheet, [part], loaded=kind == "core")
        away = max(float((side * ring[:, 1]).max()) for ring in part.piece.rings) * side + 2.5 * side * radius
        yield _draw_core(hull, away) if kind == "core" else _draw_ball(away, 0.0, radius, BALLAST)
        yield from _draw_arrow((away - 1.3 * side * radius, 0.0), (z + 1.3 * side * radius, 0.0))
        (place,) = (_draw_core(hull, z) if kind == "core" else _draw_ball(z, 0.0, radius, "none")).lines
        yield Shape([np.append(place, place[:1], axis=0)], dash="2 2")
    elif kind in ("join", "open"):
        part = parts[int(which) - 1]
        heights = np.concatenate(part.piece.rings)[:, 1]
        shift = (1.0 if part.place > first.place else -1.0) * max(0.3 * float(np.ptp(heights)), hull.core)
        yield from _lay(sheet, parts[: int(which) - 1], core=True)
        yield from _lay(sheet, [part], shift)
        at = float(heights.mean()) + shift
        begin, end = (at, at - 1.2 * shift)[:: 1 if kind == "join" else -1]
        yield from _draw_arrow((begin, 0.75 * wide), (end, 0.75 * wide))
    elif kind == "hang":
        low, high, top = sheet.aft - wide / 2, sheet.aft + length + wide / 2, 2.4 * wide
        water, at = 1.2 * wide, 1e3 * float(sheet.target.cog[0])
        yield Shape([np.array([[low, -wide], [high, -wide], [high, water], [low, water]])], WATER)
        yield Shape([np.array([[low, 1.5 * wide], [low, -wide], [high, -wide], [high, 1.5 * wide]])], width=1.4)
        yield from _lay(sheet, parts, core=True)
        yield Shape([np.array([[at, hull.skin_radius(at)], [at, top]])])
        box = np.array([[-1.0, 0.0], [1.0, 0.0], [1.0, 0.7], [-1.0, 0.7]]) * wide + (at, top)
        yield Shape([box], _PALE)
    else:
        yield from _lay(sheet, parts, core=True)
        ends = ((-1.0, sheet.aft), (1.0, sheet.aft + length)) if kind == "putty" else ()
        for side, end in ends:
            if all(side * ring[0, 1] < 0 for ring in sheet.putty):
                continue
            yield from _draw_arrow((end + side * wide / 2, 0.0), (end + side * wide / 12, 0.0))
        if not ends:
            balance = 1e3 * float(sheet.target.cog[0])
            edge = np.array([[0.0, 0.0], [-0.3, -0.6], [0.3, -0.6]]) * wide
            edge += (balance, -hull.skin_radius(balance))
            yield Shape([edge], style.INK)


def _mirror(rings: Sequence[Ring], x: float = 0.0) -> list[FloatArray]:
    return [ring * (side, 1.0) + (x, 0.0) for ring in rings for side in (1.0, -1.0)]


def _stand(part: SheetPart, x: float) -> Iterator[Shape]:
    colour = colour_of(part.place)
    yield Shape(_mirror(part.printed, x), style.tint(colour, 0.45))
    yield Shape([np.array([[x, part.size[1] / 2]])], mark=str(part.number), colour=colour)


def _lay(
    sheet: Sheet, parts: Sequence[SheetPart], shift: float = 0.0, core: bool = False, loaded: bool = True
) -> Iterator[Shape]:
    """Parts as joined, fore to the right, with their numbers, the core, and balls of ballast if they are ``loaded``."""
    ends = sheet.bounds
    for part in parts:
        lines = [ring[:, ::-1] + (shift, 0.0) for ring in _mirror(part.piece.rings)]
        yield Shape(lines, style.tint(colour_of(part.place), 0.45))
    if core:
        yield _draw_core(sheet.kit.hull, 0.0)
    for ball in sheet.balls if loaded else ():
        if any(part.number == ball.number for part in parts):
            yield _draw_ball(ball.held.ball.z + shift, 0.0, ball.held.ball.radius, BALLAST)
    for part in parts:
        middle = (ends[part.place] + ends[part.place + 1]) / 2
        at = np.array([[middle + shift, sheet.kit.hull.skin_radius(middle)]])
        yield Shape([at], mark=str(part.number), colour=colour_of(part.place))


def _draw_ball(x: float, y: float, radius: float, fill: str) -> Shape:
    return Shape([_CIRCLE * radius + (x, y)], fill)


def _draw_core(hull: Hull, x: float, y: float = 0.0) -> Shape:
    if hull.capsule is None:
        return _draw_ball(x, y, hull.core, CORE)
    outline = np.concatenate((hull.capsule, hull.capsule[::-1] * (1.0, -1.0)))
    return Shape([outline + np.array([x, y])], CORE)


def _draw_floor(left: float, right: float, level: float = 0.0) -> Shape:
    return Shape([np.array([[left, level], [right, level]])], width=1.4)


def _draw_arrow(tail: tuple[float, float], head: tuple[float, float]) -> Iterator[Shape]:
    ends = np.array([tail, head])
    along = (ends[1] - ends[0]) * min(0.3, _HEAD / float(np.ptp(ends, axis=0).max()))
    across = np.array([-along[1], along[0]]) / 2
    yield Shape([ends], width=1.4)
    yield Shape([ends[1] + [across - along, (0.0, 0.0), -across - along]], width=1.4)
