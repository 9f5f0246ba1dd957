"""Contour -> panels: the division of the meridian."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

SMOOTH = np.deg2rad(5)
"""Largest turn of a contour at a joint of a smooth curve that consists of short edges, rad."""

SAGITTA = 5e-4
"""Largest distance of such a curve from its edges, relative to the contour's largest radius."""

SHARP = np.deg2rad(35)
"""Turn above which panels get shorter towards a corner, rad."""

ARC = np.deg2rad(22.5)
"""Turn of a curve along one panel, rad."""

GROWTH = 1.0
"""Increase of a panel's length per unit of its distance from a sharp corner."""

CROWDING = 0.8
"""Concentration of the points of a panel at its corner, from 0, uniform, to 1, unlimited."""

_STATIONS = np.concatenate([(np.arange(12) / 12) ** 3, 2 - (np.arange(12, -1, -1) / 12) ** 3]) / 2
"""Stations along an edge, from 0 to 1, dense at its ends."""

_THIRDS = np.arange(4) / 3
_CUBIC = np.linalg.inv(np.vander(_THIRDS))
_MIDDLE, _MIDDLE_SLOPE = np.array([1 / 8, 1 / 4, 1 / 2, 1]), np.array([3 / 4, 1, 1, 0])


@dataclass(frozen=True, eq=False)
class Panels:
    """The pieces of a meridian, from aft to fore, each a curve (x(u), r(u)) with u from 0 to 1, and their lengths, m, (n,).

    ``x`` and ``r`` are polynomials in u, m, highest power first, (n, 4).
    """

    x: FloatArray
    r: FloatArray
    lengths: FloatArray

    def __post_init__(self) -> None:
        for values in (self.x, self.r, self.lengths):
            values.setflags(write=False)

    def thinnest_wall(self) -> float:
        """Return the least distance between panels that are back to back, relative to their length; infinity without any.

        As a wall gets thin, the equations for its two sides become identical and magnify the error of the
        discretisation.
        """
        middle = np.column_stack([self.x @ _MIDDLE, self.r @ _MIDDLE])
        tangent = np.column_stack([self.x @ _MIDDLE_SLOPE, self.r @ _MIDDLE_SLOPE])
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        normal = tangent[:, ::-1] * (-1.0, 1.0)
        # The position of the middle of each panel (row) relative to that of each other (column), in the axes of the other.
        ahead = middle @ normal.T - (middle * normal).sum(axis=1)
        beside = np.abs(middle @ tangent.T - (middle * tangent).sum(axis=1))
        facing = (normal @ normal.T < -0.5) & (ahead < 0) & (2 * beside < self.lengths[:, None] + self.lengths)
        return float(np.where(facing, -ahead / self.lengths, np.inf).min())


def make_panels(contour: npt.ArrayLike, count: int, corner: float) -> Panels:
    """Divide a contour.

    Consecutive edges that are short and turn little (``SMOOTH``, ``SAGITTA``) form one curve; a panel ends at every
    other joint. Every other edge therefore has at least one panel, which follows it exactly. A panel on a curve is the
    cubic through four points of the curve. Panels are shorter near a sharp corner and on a tight curve. The mirrored
    contour has the mirrored panels.

    At a corner the potential has a part that varies as the distance to the power pi / (pi + turn), which is not a
    polynomial. The points of a panel are denser there, which makes the potential smoother in the panel's parameter than
    along the arc.

    The contour is x and r, m, (n, 2), from the aft axis point to the fore axis point; ``count`` is the number of panels of a
    straight meridian without corners, and ``corner`` the length of a panel at a sharp corner, relative to the corner's radius.
    """
    points, edges, lengths = _clean_contour(np.asarray(contour, dtype=np.float64))
    along = np.concatenate([[0.0], np.cumsum(lengths)])

    # Joints lie between edges; the ends of the contour count as joints without a turn.
    cross = edges[:-1, 0] * edges[1:, 1] - edges[:-1, 1] * edges[1:, 0]
    turns = np.abs(np.arctan2(cross, (edges[:-1] * edges[1:]).sum(axis=1)))
    sagittas = turns * (lengths[:-1] + lengths[1:]) / 16
    curved = (turns <= SMOOTH) & (sagittas <= SAGITTA * points[:, 1].max())
    ends = np.concatenate([[0], 1 + np.flatnonzero(~curved), [len(edges)]])
    turn_at = np.concatenate([[0.0], turns, [0.0]])
    bends = np.concatenate([[0.0], np.where(curved, turns, 0.0), [0.0]])

    # The wanted number of panels up to each station of each edge, counted from the start of its curve.
    curve = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
    begin, close = along[ends[:-1]][curve, None], along[ends[1:]][curve, None]
    sizes = np.where(turn_at > SHARP, corner * points[:, 1], np.inf)
    size_aft, size_fore = sizes[ends[:-1]][curve, None], sizes[ends[1:]][curve, None]
    station = along[:-1, None] + lengths[:, None] * _STATIONS
    smooth = lengths * count / along[-1] + (bends[:-1] + bends[1:]) / 2 / ARC
    before = np.cumsum(smooth) - smooth
    before -= before[ends[:-1]][curve]
    wanted = (
        (before[:, None] + smooth[:, None] * _STATIONS)
        + np.log1p(GROWTH * (station - begin) / size_aft) / GROWTH
        + np.log1p(GROWTH * (close - begin) / size_fore) / GROWTH
        - np.log1p(GROWTH * (close - station) / size_fore) / GROWTH
    )

    # An integer for each curve; the last station of an edge is the first of the next.
    total = wanted[ends[1:] - 1, -1]
    whole = np.maximum(np.ceil(total - 1e-6), 1).astype(int)
    last = np.cumsum(whole)
    measure = wanted * (whole / total)[curve, None] + (last - whole)[curve, None]
    breaks = np.interp(np.arange(last[-1] + 1), measure.ravel(), station.ravel())
    breaks[np.concatenate([[0], last])] = along[ends]

    is_corner = turn_at[ends] > SMOOTH
    crowding = np.zeros((2, last[-1]))
    crowding[0, last - whole] = CROWDING * is_corner[:-1]
    crowding[1, last - 1] = CROWDING * is_corner[1:]
    where = breaks[:-1, None] + np.diff(breaks)[:, None] * _crowd_points(crowding[0, :, None], crowding[1, :, None])
    x, r = (np.interp(where, along, points[:, k]) @ _CUBIC.T for k in (0, 1))
    return Panels(x, r, np.diff(breaks))


def _clean_contour(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points, edges and lengths of a contour, without edges of zero length and edges on the axis at an end.

    Raises ValueError if the contour does not start and end on the axis, or has no point off the axis.
    """
    radii = points[:, 1]
    on_axis = np.abs(radii) <= 1e-9 * np.abs(radii).max()
    if on_axis.all() or not (on_axis[0] and on_axis[-1]) or (radii[~on_axis] < 0).any():
        raise ValueError("a contour must start and end on the axis, with points at r > 0 between")
    inside = np.flatnonzero(~on_axis)
    points = points[inside[0] - 1 : inside[-1] + 2]
    edges = np.diff(points, axis=0)
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    keep = lengths > 1e-9 * lengths.sum()
    points = np.concatenate([points[:-1][keep], points[-1:]])
    return points, np.diff(points, axis=0), lengths[keep]


def _crowd_points(aft: FloatArray, fore: FloatArray) -> FloatArray:
    """Return the positions along a panel, from 0 to 1, at the thirds of its parameter u, (n, 4).

    Its derivative is 1 - aft (1 - u)^2 - fore u^2, scaled to end at 1.
    """
    u = _THIRDS
    place = u - aft * (1 - (1 - u) ** 3) / 3 - fore * u**3 / 3
    return np.asarray(place / (1 - aft / 3 - fore / 3), dtype=np.float64)
