"""The pipe for display: cut open along its length, with equally spaced rings."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from driftform.figures import style
from driftform.types import FloatArray
from driftform.water import Pipe, Scenario
from driftform.water.parts import shapes
from driftform_exudyn.shapes import GLOWING, Shape, make_line, make_ribbons, make_text, place, revolve

LIT = "#576670"
"""Colour that light adds to the luminous wall: its upper part would otherwise be dark, seen from inside."""

LINE_POINTS = 65
"""Points of a long line: the ray tracer drops segments with neither end in view."""

CHORD = 0.5
"""Length of the straight pieces that stand for a bend, a reducer or a tee, in radii of the bore."""

THICKNESS = 0.03
"""Thickness of the displayed wall, relative to the bore's radius."""


def upright_axes(scenario: Scenario) -> FloatArray:
    """Return right (downstream), up, and towards the viewer in the world frame: rows, (3, 3)."""
    right, up = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    if not scenario.pipe.is_open:
        layout = scenario.pipe.layout
        level = (layout.outlets[-1].opening.centre - layout.inlet.centre) * (1, 1, 0)
        length = float(np.linalg.norm(level))
        right = level / length if length > 1e-9 else right
    return np.stack([right, up, np.cross(right, up)])


@dataclass(frozen=True, eq=False)
class Bore:
    """A straight piece of pipe, m; rows of ``axes`` are its axis, up, and the direction of the back wall, (3, 3)."""

    start: FloatArray
    length: float
    radius: float
    axes: FloatArray

    @classmethod
    def between(cls, start: FloatArray, end: FloatArray, radius: float, viewer: FloatArray) -> "Bore":
        """Return the bore from ``start`` to ``end`` (m, (3,)) seen across it, from the direction ``viewer`` (world, (3,))."""
        length = float(np.linalg.norm(end - start))
        axis = (end - start) / length
        back = axis * (viewer @ axis) - viewer
        if np.linalg.norm(back) < 1e-6:
            # The viewer looks along the bore: the lower half of its wall is shown.
            back = np.array([0.0, 0.0, -1.0]) - axis * -axis[2]
        back /= np.linalg.norm(back)
        return cls(start, length, radius, np.stack([axis, np.cross(axis, back), back]))

    def point(self, along: FloatArray | float, radius: FloatArray | float, angle: FloatArray | float) -> FloatArray:
        """Return points of the world by cylindrical coordinates, ``angle`` (rad) from up towards the back, m, (..., 3)."""
        axis, up, back = self.axes
        x, r, a = (np.asarray(value, dtype=np.float64)[..., None] for value in (along, radius, angle))
        return np.asarray(self.start + x * axis + r * (np.cos(a) * up + np.sin(a) * back), dtype=np.float64)

    def make_shapes(
        self, first: float, last: float, step: float, low: float = -np.inf, high: float = np.inf
    ) -> list[Shape]:
        """Return the pipe from ``first`` to ``last`` (m along the axis), with a ring every ``step`` (m).

        The back wall is drawn from ``low`` to ``high`` (m above the axis), the range in view.
        """
        first, last = max(first, 0.0), min(last, self.length)
        bottom, top = np.clip([low / self.radius, high / self.radius], -1.0, 1.0)
        if last <= first or top <= bottom:
            return []
        half = np.linspace(np.arccos(top), np.arccos(bottom), 37)
        # From the far end to the near one, so that the surface faces inward.
        stations = np.linspace(last, first, 2 + int((last - first) / step))
        contour = np.column_stack([stations, np.full(len(stations), self.radius)])
        inside = revolve(contour, self.axes, half, [LIT] * (len(stations) - 1), GLOWING)
        # Lines lie just inside the wall, which would hide them otherwise.
        near = 0.985 * self.radius
        marks = np.arange(np.ceil(first / step - 1e-9), np.floor(last / step + 1e-9) + 1) * step
        # Rings stop short of the edges, where parts of them would show through the wall.
        ring = np.clip(half, 0.2, np.pi - 0.2)
        rings = [make_line(self.point(s, near, ring), style.tint(style.WALL, 0.4)) for s in marks]
        stripes = [
            make_line(self.point(np.linspace(first, last, LINE_POINTS), near, a), style.tint(style.WALL, 0.2))
            for a in np.deg2rad(np.arange(15, 180, 15))
            if half[0] < a < half[-1]
        ]
        return [place(inside, 1.0, self.start), self._make_section(first, last), *rings, *stripes]

    def _make_section(self, first: float, last: float) -> Shape:
        angles = np.array([0.0, np.pi])[:, None, None]
        rims = self.radius * np.array([1.0, 1 + THICKNESS])[:, None]
        grid = self.point(np.array([first, last]), rims, angles)
        return make_ribbons(grid, np.broadcast_to(-self.axes[2], grid.shape), [style.tint(style.WALL, 0.6)] * 2)

    def make_labels(self, step: float, size: float, gap: float) -> list[Shape]:
        """Return the distances from the inlet every ``step`` (m), ``gap`` (m) below the pipe, in letters of ``size`` px."""
        return [
            make_text(self.point(s, self.radius + gap, np.pi), f"{s:g} m", style.MUTED, size)
            for s in np.arange(np.floor(self.length / step + 1e-9) + 1) * step
        ]


def list_bores(pipe: Pipe, viewer: FloatArray) -> list[Bore]:
    """Return a pipe as straight pieces, seen from the direction ``viewer`` (world, (3,)); none in open water."""
    bores = []
    for placed in pipe.layout.parts:
        part = placed.part
        step = part.length if isinstance(part, shapes.Straight) else CHORD * part.end_radius
        for number, axis in enumerate(part.list_axes(step)):
            for (start, end), (first, last) in zip(pairwise(axis.points), pairwise(axis.radii), strict=True):
                away = float(np.linalg.norm(end - part.origin))
                if isinstance(part, shapes.Tee) and number == 1 and away * np.sin(part.angle) < part.radius:
                    continue
                # Outside a bend, chords of the axis' own length would leave wedges between them.
                turn = part.angle / (len(axis.points) - 1) if isinstance(part, shapes.Bend) else 0.0
                more = part.radius * np.tan(0.5 * turn) * (end - start) / np.linalg.norm(end - start)
                bores.append(Bore.between(start - more, end + more, 0.5 * float(first + last), viewer))
    return bores


def make_lattice(axes: FloatArray, centre: FloatArray, seen: FloatArray, step: float) -> list[Shape]:
    """Return a grid of lines ``step`` (m) apart on a plane through ``centre``, to show motion in open water.

    ``axes`` are right, up and towards the viewer; ``seen`` is the extent of the lines, width and height (m).
    """
    lines = []
    for i in (0, 1):
        along, across, middle = axes[i], axes[1 - i], float(centre @ axes[i])
        ends = centre + np.linspace(-0.5, 0.5, LINE_POINTS)[:, None] * seen[1 - i] * across
        first, last = np.ceil((middle - seen[i] / 2) / step), np.floor((middle + seen[i] / 2) / step)
        lines += [
            make_line(ends + (n * step - middle) * along, style.tint(style.BLUE, 0.15))
            for n in np.arange(first, last + 1)
        ]
    return lines
