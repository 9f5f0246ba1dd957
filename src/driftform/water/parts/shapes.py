"""Parts of a pipe in their places: straights, bends, reducers and tees, each with its frame, its axes and its bore.

The local frame of a part has x downstream along its axis and z in the direction of its ``roll``: a bend turns towards z, and
the branch of a tee leaves towards z. The origin is the centre of the part's entry; of a tee, the point where its two axes meet.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from driftform.types import BoolArray, FloatArray

VERTICAL = 1e-3
"""Horizontal component of a unit vector below which it is vertical: no direction across it is then the upward one.

It is a millimetre in a metre: how a riser deviates from the vertical does not turn its clock.
"""

TEE_LEG = 2.0
"""Length of the legs of a tee beyond its rounded edge, in radii of their bores.

There the ideal flow in a tee differs from plug flow by less than one percent of the mean speed: its slowest mode decays as
exp(-1.84 s / R), and begins at about a third of the mean speed.
"""


@dataclass(frozen=True, eq=False)
class Opening:
    """One end of a part: its ``centre`` (m, (3,)), ``axes`` (rows: downstream, left, up; (3, 3)) and ``radius`` (m)."""

    centre: FloatArray
    axes: FloatArray
    radius: float


@dataclass(frozen=True, eq=False)
class Axis:
    """``points`` of the axis of a bore from one end to the other, m, (k, 3), with the ``radii`` of the bore there, m, (k,)."""

    points: FloatArray
    radii: FloatArray

    @property
    def lengths(self) -> FloatArray:
        """Distance of each point from the first one along the axis, m, (k,)."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])


@dataclass(frozen=True, eq=False)
class PipePart(ABC):
    """A part of a pipe.

    Attributes:
        origin: of the local frame in the world frame, m, (3,).
        axes: rows: x, y and z of the local frame in the world frame, (3, 3).
        radius: of the bore at the entry, m.
    """

    origin: FloatArray
    axes: FloatArray
    radius: float

    @property
    def end_radius(self) -> float:
        """Radius of the bore at the end of the run, m."""
        return self.radius

    @property
    def narrowest(self) -> float:
        """Radius of the narrowest bore, m."""
        return min(self.radius, self.end_radius)

    @property
    def bulge(self) -> float:
        """Least radius of curvature with which the wall bulges into the water along the pipe, m; infinite without any."""
        return math.inf

    @property
    @abstractmethod
    def length(self) -> float:
        """Length of the run along its axis, m."""

    def bore_radii(self, x: FloatArray) -> FloatArray:
        """Return the radius of the bore at ``x`` (m) from the entry, m, (n,)."""
        return np.full(len(x), self.radius)

    def list_exits(self) -> tuple[Opening, ...]:
        """Return the downstream end of the run, and then that of the branch, if there is one."""
        return (Opening(self.origin + self.length * self.axes[0], self.axes, self.end_radius),)

    def list_axes(self, step: float) -> tuple[Axis, ...]:
        """Return the axis of the run, and then that of the branch, in points at most ``step`` (m) apart."""
        x = _divide(0.0, self.length, step)
        return (Axis(self.to_world(_along_x(x)), self.bore_radii(x)),)

    def find_inside(self, local: FloatArray, margin: float = 0.0) -> BoolArray:
        """Return whether points of the local frame (m, (n, 3)) lie in the part or within ``margin`` (m) of its ends, (n,)."""
        x, across = local[:, 0], np.hypot(local[:, 1], local[:, 2])
        return np.asarray(
            (x >= -margin) & (x <= self.length + margin) & (across <= self.bore_radii(x) + 1e-12 * self.radius)
        )

    def list_rims(self, step: float, count: int) -> list[FloatArray]:
        """Return circles of ``count`` points on the wall of each bore, at most ``step`` apart along its axis, m, (k, count, 3) each."""
        angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
        rims = []
        for axis in self.list_axes(step):
            first = np.cross(np.gradient(axis.points, axis=0), self.axes[1])
            first /= np.linalg.norm(first, axis=1, keepdims=True)
            circle = np.cos(angle)[:, None] * first[:, None] + np.sin(angle)[:, None] * self.axes[1]
            rims.append(axis.points[:, None] + axis.radii[:, None, None] * circle)
        return rims

    @property
    def entry(self) -> FloatArray:
        """The centre of the upstream end, m, (3,)."""
        return self.origin

    def to_local(self, points: FloatArray) -> FloatArray:
        """Return points of the world frame in the local one, m, (n, 3)."""
        return np.asarray((points - self.origin) @ self.axes.T)

    def to_world(self, local: FloatArray) -> FloatArray:
        """Return points of the local frame in the world frame, m, (n, 3)."""
        return np.asarray(self.origin + local @ self.axes)


@dataclass(frozen=True, eq=False)
class Straight(PipePart):
    """A cylinder of the length ``straight`` (m)."""

    straight: float

    @property
    def length(self) -> float:
        """Length, m."""
        return self.straight


@dataclass(frozen=True, eq=False)
class Bend(PipePart):
    """A part of a torus: the axis turns by ``angle`` (rad) about a centre at ``bend_radius`` (m) along z."""

    bend_radius: float
    angle: float

    @property
    def bulge(self) -> float:
        """Radius of the inside of the bend, m."""
        return self.bend_radius - self.radius

    @property
    def length(self) -> float:
        """Length of the axis, m."""
        return self.bend_radius * self.angle

    def list_exits(self) -> tuple[Opening, ...]:
        """Return the downstream end, whose z points to the bend's centre as that of the entry does."""
        c, s = exact_cosine(self.angle), exact_sine(self.angle)
        centre = self.to_world(self.bend_radius * np.array([[s, 0.0, 1 - c]]))[0]
        x, y, z = self.axes
        return (Opening(centre, np.stack([c * x + s * z, y, c * z - s * x]), self.radius),)

    def list_axes(self, step: float) -> tuple[Axis, ...]:
        """Return the axis."""
        turn = _divide(0.0, self.angle, step / self.bend_radius)
        local = np.column_stack([np.sin(turn), np.zeros(len(turn)), 1 - np.cos(turn)])
        return (Axis(self.to_world(self.bend_radius * local), np.full(len(turn), self.radius)),)

    def find_inside(self, local: FloatArray, margin: float = 0.0) -> BoolArray:
        """Return whether points of the local frame lie inside, (n,)."""
        x, y, z = local.T
        turn, share = np.arctan2(x, self.bend_radius - z), margin / self.bend_radius
        # Just upstream of the entry the angle is slightly negative, and not nearly a whole turn.
        turn = np.where(turn < -share - 1e-12, turn + 2 * np.pi, turn)
        across = np.hypot(np.hypot(x, self.bend_radius - z) - self.bend_radius, y)
        return np.asarray((turn <= self.angle + share) & (across <= self.radius))


@dataclass(frozen=True, eq=False)
class Reducer(PipePart):
    """A change of the bore to ``narrow`` (m; it may also be wider) over the length ``taper`` (m).

    The meridian of the wall is an ogee: two arcs of circles of the same radius, tangent to each other and to the bores.
    """

    narrow: float
    taper: float

    @property
    def end_radius(self) -> float:
        """Radius of the bore at the end, m."""
        return self.narrow

    @property
    def length(self) -> float:
        """Length, m."""
        return self.taper

    @property
    def bulge(self) -> float:
        """Radius of the two arcs, m: that of a chord of half the ogee which starts along the axis."""
        change = abs(self.narrow - self.radius)
        return (self.taper**2 + change**2) / (4 * change)

    def bore_radii(self, x: FloatArray) -> FloatArray:
        """Return the radius of the bore at ``x`` (m) from the entry, m, (n,)."""
        x = np.clip(x, 0.0, self.taper)
        # Both arcs end half way.
        near = np.minimum(x, self.taper - x)
        rise = math.copysign(1.0, self.narrow - self.radius) * (self.bulge - np.sqrt(self.bulge**2 - near**2))
        radii = np.where(2 * x < self.taper, self.radius + rise, self.narrow - rise)
        return np.asarray(radii)


@dataclass(frozen=True, eq=False)
class Tee(PipePart):
    """A run with a branch, whose axis leaves that of the run at ``angle`` (rad, from downstream) towards z.

    The edge between the two bores is rounded: a ball of the radius ``fillet`` (m) that rolls in the wall along both.
    ``branch_radius`` (m) is that of the branch's bore, ``share`` that of the water that leaves by it.
    """

    branch_radius: float
    angle: float
    fillet: float
    share: float

    @property
    def narrowest(self) -> float:
        """Radius of the narrower bore, m."""
        return min(self.radius, self.branch_radius)

    @property
    def bulge(self) -> float:
        """Radius of the rounded edge, m."""
        return self.fillet

    @property
    def length(self) -> float:
        """Length of the run, m."""
        upstream, downstream, _ = self.legs
        return upstream + downstream

    @property
    def entry(self) -> FloatArray:
        """The centre of the upstream end, m, (3,)."""
        return np.asarray(self.origin - self.legs[0] * self.axes[0])

    @property
    def legs(self) -> tuple[float, float, float]:
        """Distances from the origin to the upstream end, the downstream end, and the end of the branch, m."""
        return tee_legs(self.radius, self.branch_radius, self.angle, self.fillet)

    @property
    def ray(self) -> FloatArray:
        """Unit vector along the branch, in the local frame, (3,)."""
        return np.array([exact_cosine(self.angle), 0.0, exact_sine(self.angle)])

    @property
    def branch_axes(self) -> FloatArray:
        """Rows: along the branch, y, and normal to both, in the world frame, (3, 3)."""
        c, s = exact_cosine(self.angle), exact_sine(self.angle)
        x, y, z = self.axes
        return np.stack([c * x + s * z, y, c * z - s * x])

    def list_exits(self) -> tuple[Opening, ...]:
        """Return the downstream end of the run, and the end of the branch."""
        _, downstream, side = self.legs
        branch = self.branch_axes
        return (
            Opening(self.origin + downstream * self.axes[0], self.axes, self.radius),
            Opening(self.origin + side * branch[0], branch, self.branch_radius),
        )

    def list_axes(self, step: float) -> tuple[Axis, ...]:
        """Return the axis of the run, and that of the branch from the run's axis on."""
        upstream, downstream, side = self.legs
        x, t = _divide(-upstream, downstream, step), _divide(0.0, side, step)
        return (
            Axis(self.to_world(_along_x(x)), np.full(len(x), self.radius)),
            Axis(self.origin + t[:, None] * self.branch_axes[0], np.full(len(t), self.branch_radius)),
        )

    def find_inside(self, local: FloatArray, margin: float = 0.0) -> BoolArray:
        """Return whether points of the local frame lie inside, (n,); the rounding of the edge counts as wall."""
        upstream, downstream, side = self.legs
        c, s = exact_cosine(self.angle), exact_sine(self.angle)
        x, y, z = local.T
        along, across = c * x + s * z, np.hypot(y, c * z - s * x)
        run = (x >= -upstream - margin) & (x <= downstream + margin) & (np.hypot(y, z) <= self.radius)
        return np.asarray(run | ((along >= 0) & (along <= side + margin) & (across <= self.branch_radius)))


def locate_on_axis(part: PipePart, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Return where points of the world frame (m, (n, 3)) lie along the axis of a part.

    That is the distance from the entry along the axis (m, (n,)), the nearest point of the axis (m, (n, 3)), the axes there
    (downstream, left, up, (n, 3, 3)), and whether that axis is the one of a branch, (n,).
    """
    local = part.to_local(points)
    along, on_branch = local[:, 0], np.zeros(len(points), dtype=bool)
    match part:
        case Bend():
            turn = np.arctan2(local[:, 0], part.bend_radius - local[:, 2])
            along = part.bend_radius * np.where(turn < 0.5 * (part.angle - 2 * np.pi), turn + 2 * np.pi, turn)
        case Tee():
            t = local @ part.ray
            across = np.linalg.norm(local - t[:, None] * part.ray, axis=1) - part.branch_radius
            on_branch = (t > 0) & (across < np.hypot(local[:, 1], local[:, 2]) - part.radius)
            along = part.legs[0] + np.where(on_branch, t, along)
    return along, *_follow_axis(part, along, on_branch), on_branch


def place_on_axis(part: PipePart, along: FloatArray, on_branch: bool = False) -> tuple[FloatArray, FloatArray]:
    """Return the points at distances along the axis of a part, and the axes there: what :func:`locate_on_axis` inverts.

    Args:
        along: distances from the entry along the axis, m, (n,).
        on_branch: whether that axis is the one of a tee's branch, which begins at the axis of its run.

    Returns:
        points: m, (n, 3).
        axes: downstream, left and up, rows, (n, 3, 3).
    """
    return _follow_axis(part, along, np.full(len(along), on_branch))


def _follow_axis(part: PipePart, along: FloatArray, on_branch: BoolArray) -> tuple[FloatArray, FloatArray]:
    feet, directions = _along_x(along), np.tile(np.array([1.0, 0.0, 0.0]), (len(along), 1))
    match part:
        case Bend():
            s, c, zero = np.sin(along / part.bend_radius), np.cos(along / part.bend_radius), np.zeros(len(along))
            feet = part.bend_radius * np.column_stack([s, zero, 1 - c])
            directions = np.column_stack([c, zero, s])
        case Tee():
            feet = _along_x(along - part.legs[0])
            feet = np.where(on_branch[:, None], feet[:, :1] * part.ray, feet)
            directions = np.where(on_branch[:, None], part.ray, directions)
    return part.to_world(feet), _axes_along(part, directions)


def _axes_along(part: PipePart, directions: FloatArray) -> FloatArray:
    """Return the axes of a bore with each direction (unit vectors of the local frame, (n, 3)), rows, (n, 3, 3)."""
    if not len(directions):
        return np.empty((0, 3, 3))
    # Most parts have one direction, and a branch another one.
    different, which = np.unique(directions, axis=0, return_inverse=True)
    axes = np.stack([upright_axes(x, carry_axes(x, part.axes)) for x in different @ part.axes])
    return np.asarray(axes[which.reshape(-1)])


def carry_axes(direction: FloatArray, axes: FloatArray) -> FloatArray:
    """Return axes (rows, (3, 3)) turned the shortest way so that the first has a ``direction``, a unit vector, (3,)."""
    x, cosine = axes[0], float(axes[0] @ direction)
    if cosine > 1 - 1e-12:
        return axes
    across = np.cross(x, direction) if cosine > -1 + 1e-12 else axes[1]
    cross = np.array([[0, -across[2], across[1]], [across[2], 0, -across[0]], [-across[1], across[0], 0]])
    turn = (
        np.eye(3) + cross + cross @ cross / (1 + cosine)
        if cosine > -1 + 1e-12
        else 2 * np.outer(across, across) - np.eye(3)
    )
    return np.asarray(axes @ turn.T)


def tee_legs(radius: float, branch_radius: float, angle: float, fillet: float) -> tuple[float, float, float]:
    """Return the distances (m) from the origin of a tee to its upstream end, its downstream end, and the end of its branch.

    The legs end :data:`TEE_LEG` radii beyond the last point of the rounded edge.
    """
    c, s = exact_cosine(angle), exact_sine(angle)
    rho, height = branch_radius + fillet, radius + fillet
    return (
        (rho - height * c) / s + TEE_LEG * radius,
        (rho + height * c) / s + TEE_LEG * radius,
        (height + rho * abs(c)) / s + TEE_LEG * branch_radius,
    )


def exact_cosine(angle: float) -> float:
    """Return the cosine of an angle (rad), exact for multiples of a right angle."""
    return exact_sine(angle + math.pi / 2)


def exact_sine(angle: float) -> float:
    """Return the sine of an angle (rad), exact for multiples of a right angle.

    >>> exact_sine(math.pi), exact_cosine(math.pi / 2)
    (0.0, 0.0)
    """
    quarters = angle / (math.pi / 2)
    whole = round(quarters)
    return (0.0, 1.0, 0.0, -1.0)[whole % 4] if abs(quarters - whole) < 1e-12 else math.sin(angle)


def upright_axes(direction: FloatArray, carried: FloatArray | None = None) -> FloatArray:
    """Return the axes of a bore: downstream, left, and up as far as it goes, rows, (3, 3).

    Nothing is up in a vertical bore: there the axes are as near as they can be to those ``carried`` along from the bore
    before it, or to those of a bore that is bent in the plane y = 0.
    """
    x = direction / np.linalg.norm(direction)
    level = math.hypot(x[0], x[1])
    if level < VERTICAL:
        if carried is not None and np.abs(carried[0] - x).max() < 1e-12:
            return carried
        up = np.array([-math.copysign(1.0, x[2]), 0.0, 0.0]) if carried is None else carried[2]
        across = up - (up @ x) * x
        z = across / np.linalg.norm(across)
        return np.stack([x, np.cross(z, x), z])
    y = np.array([-x[1], x[0], 0.0]) / level
    return np.stack([x, y, np.cross(x, y)])


def roll_axes(axes: FloatArray, roll: float) -> FloatArray:
    """Return axes (rows, (3, 3)) rolled about the first by an angle (rad), clockwise as seen downstream."""
    c, s = exact_cosine(roll), exact_sine(roll)
    x, y, z = axes
    return np.stack([x, c * y + s * z, c * z - s * y])


def _divide(first: float, last: float, step: float) -> FloatArray:
    return np.linspace(first, last, max(2, 1 + math.ceil((last - first) / step)))


def _along_x(x: FloatArray) -> FloatArray:
    return np.column_stack([x, np.zeros((len(x), 2))])
