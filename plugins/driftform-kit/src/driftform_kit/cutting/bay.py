"""The bay: seats that hold the core at the origin if the hull itself does not.

A hull that narrows on both sides of the core holds it. If one side is wide, the core could move along the axis: a
seat is added there, a cone that runs from the wall to the core, normal to the core's surface. Its slope is at most 45
degrees, so that it prints without support with the closed end of its part on the bed. Balls of ballast get the same seats.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from manifold3d import CrossSection

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_kit.cutting import meridian
from driftform_kit.cutting.meridian import Hull

SEAT = 1.2
"""mm, thickness of a seat: three lines of the usual nozzle."""

MIN_TUBE = 1.0
"""mm: least radius inside a tube that holds a ball."""

PLAY = 0.5
"""mm that the core may move along the axis without a seat."""

PLAY_OF_SEATS = 2.0
"""Least play along the axis, in clearances: a seat at 45 degrees leaves 1.4."""

_LATITUDES_DEG = (45.0, 50.0, 55.0, 60.0, 65.0, 70.0)
"""Latitudes at which a seat may touch the core; the first that has room is taken."""

_STEPS = 26
"""Places tried between that of a ball and the end of its play."""

_TOUCHING = 0.01
"""mm: sections nearer than this touch."""

AREA = 1e-3
"""mm2: sections that share less than this do not meet."""


@dataclass(frozen=True)
class Ball:
    """A ball on the axis: z of its centre, and its radius, mm."""

    z: float
    radius: float

    def draw(self, gap: float = 0.0) -> CrossSection:
        """Return its disc, with a gap all round."""
        return meridian.make_disc(self.radius + gap).translate((0.0, self.z))

    @property
    def reach(self) -> float:
        """Distance of its ends from its place, mm."""
        return self.radius

    def find_foot(self, latitude: float, side: int) -> float:
        """Return z of the axis point from which a ray at a latitude (rad) on one side meets its surface squarely."""
        return self.z


@dataclass(frozen=True)
class Capsule(Ball):
    """A core that is not a ball, in its place in a hull."""

    hull: Hull

    def draw(self, gap: float = 0.0) -> CrossSection:
        """Return its section, with a gap all round."""
        return self.hull.draw_core(gap)

    @property
    def reach(self) -> float:
        """Distance of its farther end from its place, mm."""
        return self.hull.reach

    def find_foot(self, latitude: float, side: int) -> float:
        """Return where the ray begins that meets, at a latitude, the first point that a cone normal to it touches."""
        assert self.hull.capsule is not None
        z, r = self.hull.capsule.T
        first = int(np.argmax(r * math.cos(latitude) + side * z * math.sin(latitude)))
        return float(z[first] - side * r[first] * math.tan(latitude))


def core_ball(hull: Hull) -> Ball:
    """Return the core of a hull."""
    return Ball(0.0, hull.core) if hull.capsule is None else Capsule(0.0, hull.core, hull)


@dataclass(frozen=True, eq=False)
class Seat:
    """A seat's section, the index of the part that carries it, and the strip between wall and ball that it is cut from.

    The strip leaves the axis at the height ``foot`` at a latitude of ``angle_deg``, 90 degrees for a tube, and ends beyond the wall,
    after ``reach`` mm.
    """

    section: CrossSection
    part: int
    ball: Ball
    foot: float
    angle_deg: float
    reach: float


def is_held(parts: Sequence[CrossSection], ball: Ball, side: int, gap: float) -> bool:
    """Return whether a ball that moves along the axis to one side soon comes to rest on a part that centres it.

    A flat end does not: the ball rolls aside.
    """
    play = max(PLAY, PLAY_OF_SEATS * gap)
    drawn = ball.draw()
    low, high = sorted((ball.z, ball.z + side * play))
    # The part that the ball moves to comes first: it is most likely to be met.
    boxes = [(part, part.bounds()) for part in parts[::-side]]
    near = [part for part, box in boxes if box[1] <= high + 2 * ball.reach and box[3] >= low - 2 * ball.reach]

    def meets(aside: float, along: float) -> bool:
        moved = drawn.translate((aside, side * along))
        return any((moved ^ part).area() > AREA for part in near)

    if not meets(0.0, play):
        return False
    rest = next((along for along in np.linspace(0.0, play, _STEPS).tolist() if meets(0.0, along)), play)
    # A wall that touches at a lower latitude does not let it aside even if it is lifted by this much.
    lift = play / math.tan(math.radians(_LATITUDES_DEG[-1]))
    return meets(play, rest - lift)


def place_seats(hull: Hull, parts: Sequence[CrossSection], gap: float, shells: tuple[int, int]) -> list[Seat]:
    """Return the seats that keep the core at its simulated place in parts, whose sections are given as joined.

    ``gap`` is that between seat and core, mm; ``shells`` are the indices of the aft and the fore shell.

    Fails if a seat is needed and has no room.
    """
    found, core = [], core_ball(hull)
    for side in (-1, 1):
        if is_held(parts, core, side, gap):
            continue
        part = shells[0 if side < 0 else 1]
        taken = meridian.unite(p for i, p in enumerate(parts) if i != part)
        seat = draw_seat(hull, core, parts, part, taken, side, gap)
        if seat is None:
            raise WorkFailedError(
                f"no kit can be made: the core is not held on its {'fore' if side > 0 else 'aft'} side, and a seat has "
                "no room beside the joint; set joint to 'rabbet', or lap to less"
            )
        found.append(seat)
    return found


def draw_seat(
    hull: Hull, ball: Ball, parts: Sequence[CrossSection], part: int, taken: CrossSection, side: int, gap: float
) -> Seat | None:
    """Return a cone on one side of a ball that merges with a part and is clear of what is taken; ``None`` without room."""
    for latitude in _LATITUDES_DEG:
        # A strip about the ray at that latitude, for a ball from its centre.
        angle = math.radians(latitude)
        along = np.array([math.cos(angle), side * math.sin(angle)])
        across = np.array([-along[1], along[0]]) * SEAT / 2
        foot = ball.find_foot(angle, side)
        section, reach = _cut_nearest(hull, ball, (-across, across), along, gap, foot)
        if _fits(section, parts[part], taken, gap):
            return Seat(section, part, ball, foot, side * latitude, reach)
    return None


def draw_tube(
    hull: Hull, ball: Ball, parts: Sequence[CrossSection], part: int, taken: CrossSection, side: int, gap: float
) -> Seat | None:
    """Return a tube along the axis, from the wall to one side of a ball, as :func:`draw_seat`.

    In a wide bore, near its end, it is lighter than a cone. The ball lies in its mouth, at a latitude of 45 degrees.
    """
    inner = max(math.sqrt(0.5) * (ball.radius + gap), MIN_TUBE)
    walls = np.array([inner, 0.0]), np.array([inner + SEAT, 0.0])
    section, reach = _cut_nearest(hull, ball, walls, np.array([0.0, side]), gap, ball.z)
    return Seat(section, part, ball, ball.z, 90.0 * side, reach) if _fits(section, parts[part], taken, gap) else None


def _fits(section: CrossSection, part: CrossSection, taken: CrossSection, gap: float) -> bool:
    held = (meridian.grow(section, _TOUCHING) ^ part).area() > AREA
    return bool(held and (meridian.grow(section, gap) ^ taken).area() < AREA)


def _cut_nearest(
    hull: Hull, ball: Ball, corners: tuple[FloatArray, FloatArray], along: FloatArray, gap: float, foot: float
) -> tuple[CrossSection, float]:
    """The piece of a strip, given from a point of the axis, its foot, between a ball and the nearest wall; and where it ends."""
    far, (near, other) = 2 * float(np.abs(hull.skin).max()), corners
    strip = meridian.make_polygons(
        [np.array([near, far * along + near, far * along + other, other]) + np.array([0.0, foot])]
    )
    pieces = ((meridian.take_right(strip) ^ hull.inside) - ball.draw(gap)).decompose()
    if not pieces:
        return CrossSection(), 0.0
    points = [np.concatenate(piece.to_polygons()) - (0.0, foot) for piece in pieces]
    nearest = min(range(len(pieces)), key=lambda index: float(np.hypot(*points[index].T).min()))
    ends = [(float((ring @ along).min()), float((ring @ along).max())) for ring in points]
    end = ends[nearest][1]
    reach = min([end + SEAT, *((end + low) / 2 for low, _ in ends if low > end)])
    return pieces[nearest] + pieces[nearest].mirror((1.0, 0.0)), reach
