"""The pipe for other simulators: a ring of planks for collisions, and the same as a mesh for display."""

from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np

from driftform.types import FloatArray
from driftform.water import Pipe
from driftform.water.parts import shapes
from driftform_frusta.triangles import Mesh

PLANKS = 64
"""Number of planks around the bore: their faces lie within 0.08 % of its radius from the circle."""

CHORD_PLANKS = 24
"""The same in a pipe with parts, whose bores are many short chords: within 0.6 %."""

CHORD = 0.25
"""Length of these chords, in radii of the bore."""

RELATIVE_THICKNESS = 0.02
"""Thickness of the wall, relative to the radius of the bore."""

_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
"""Corners of a box of size 1, (8, 3)."""

_FACES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
"""Their indices around each face, counterclockwise from outside."""


@dataclass(frozen=True, eq=False)
class Plank:
    """A box: ``size`` along its own axes (m), ``position`` (m) and ``rotation`` (3, 3) in the pipe's frame."""

    size: FloatArray
    position: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, eq=False)
class Bore:
    """A straight pipe about the x axis of its frame, whose origin is the middle of the pipe.

    ``position`` (m) and ``rotation`` (3, 3) give that frame in the world. The wall has ``planks`` around it, but none where it
    lies in another bore of its ``part``.
    """

    length: float
    radius: float
    position: FloatArray
    rotation: FloatArray
    planks: int = PLANKS
    part: shapes.PipePart | None = None

    def make_planks(self) -> list[Plank]:
        """Return the wall as boxes, because programs replace a mesh by its convex hull, which is solid for a pipe.

        The polygon of their inner faces has the area of the bore.
        """
        half = np.pi / self.planks
        apothem, thickness = self.radius * np.sqrt(half / np.tan(half)), RELATIVE_THICKNESS * self.radius
        size = np.array([self.length, 2 * (apothem + thickness) * np.tan(half), thickness])
        axis = np.array([1.0, 0.0, 0.0])
        found = []
        for angle in 2 * half * np.arange(self.planks):
            outward = np.array([0.0, np.cos(angle), np.sin(angle)])
            rotation = np.column_stack((axis, np.cross(outward, axis), outward))
            found.append(Plank(size, (apothem + thickness / 2) * outward, rotation))
        if self.part is None:
            return found
        middles = self.position + np.array([plank.position for plank in found]) @ self.rotation.T
        inside = self.part.find_inside(self.part.to_local(middles))
        return [plank for plank, hidden in zip(found, inside, strict=True) if not hidden]


def list_bores(pipe: Pipe) -> list[Bore]:
    """Return the bores of a pipe: one of a straight pipe, short chords of the axes of one with parts, none in open water."""
    if pipe.is_open:
        return []
    if pipe.straight is not None:
        return [make_bore(np.array(pipe.straight.start), np.array(pipe.straight.end), pipe.straight.radius)]
    bores = []
    for placed in pipe.layout.parts:
        part = placed.part
        hidden = part if isinstance(part, shapes.Tee) else None
        step = part.length if isinstance(part, shapes.Straight) else CHORD * part.end_radius
        for axis in part.list_axes(step):
            # Outside a bend, chords of the axis' own length would leave wedges between them.
            turn = part.angle / (len(axis.points) - 1) if isinstance(part, shapes.Bend) else 0.0
            for (start, end), (first, last) in zip(pairwise(axis.points), pairwise(axis.radii), strict=True):
                bore = make_bore(start, end, 0.5 * (first + last))
                length = bore.length + (first + last) * np.tan(0.5 * turn)
                bores.append(replace(bore, length=length, planks=CHORD_PLANKS, part=hidden))
    return bores


def make_wall(pipe: Pipe) -> Mesh | None:
    """Return the planks of a pipe as one mesh in the world frame, ``None`` in open water."""
    boxes = [
        bore.position + (plank.position + _CORNERS * plank.size @ plank.rotation.T) @ bore.rotation.T
        for bore in list_bores(pipe)
        for plank in bore.make_planks()
    ]
    if not boxes:
        return None
    faces = (8 * np.arange(len(boxes))[:, None, None] + _FACES[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)).reshape(-1, 3)
    return Mesh(np.concatenate(boxes), faces)


def make_bore(start: FloatArray, end: FloatArray, radius: float) -> Bore:
    """Return the bore of a radius (m) between two points of its axis (m, world frame, (3,))."""
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length
    # Any direction across will do; the axis of the world with the smallest component is far from parallel.
    across = np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis)
    across /= np.linalg.norm(across)
    return Bore(length, radius, (start + end) / 2, np.column_stack((axis, across, np.cross(axis, across))))
