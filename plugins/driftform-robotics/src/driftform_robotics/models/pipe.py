"""The pipe for other simulators: a ring of planks for collisions, and a mesh for display."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from driftform.types import FloatArray
from driftform.water import Pipe, Segment
from driftform.water.parts import shapes
from driftform_frusta.triangles import Mesh
from driftform_robotics.models.meshes import make_tube
from driftform_robotics.models.walls import make_parts_mesh

PLANKS = 64
"""Number of planks around the bore: their faces lie within 0.08 % of its radius from the circle."""

CHORD_PLANKS = 24
"""The same in a pipe with parts, whose bores are many short chords: within 0.6 %."""

CHORD = 0.25
"""Length of these chords, in radii of the bore."""

RELATIVE_THICKNESS = 0.02
"""Thickness of the wall, relative to the radius of the bore."""


@dataclass(frozen=True, eq=False)
class Plank:
    """A box: ``size`` along its own axes (m), ``position`` (m) and ``rotation`` (3, 3) in the pipe's frame."""

    size: FloatArray
    position: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, eq=False)
class Wall:
    """The wall of a whole pipe as a closed ``mesh``, in a frame with its ``position`` (m) and ``rotation`` (3, 3) in the world."""

    mesh: Mesh
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

    @property
    def thickness(self) -> float:
        """Thickness of the wall, m."""
        return RELATIVE_THICKNESS * self.radius

    def make_planks(self) -> list[Plank]:
        """Return the wall as boxes, because programs replace a mesh by its convex hull, which is solid for a pipe.

        The polygon of their inner faces has the area of the bore.
        """
        half = np.pi / self.planks
        apothem = self.radius * np.sqrt(half / np.tan(half))
        size = np.array([self.length, 2 * (apothem + self.thickness) * np.tan(half), self.thickness])
        axis = np.array([1.0, 0.0, 0.0])
        found = []
        for angle in 2 * half * np.arange(self.planks):
            outward = np.array([0.0, np.cos(angle), np.sin(angle)])
            rotation = np.column_stack((axis, np.cross(outward, axis), outward))
            found.append(Plank(size, (apothem + self.thickness / 2) * outward, rotation))
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
        return [make_bore(pipe.straight)]
    bores = []
    for placed in pipe.layout.parts:
        part = placed.part
        hidden = part if isinstance(part, shapes.Tee) else None
        step = part.length if isinstance(part, shapes.Straight) else CHORD * part.end_radius
        for axis in part.list_axes(step):
            # Outside a bend, chords of the axis' own length would leave wedges between them.
            turn = part.angle / (len(axis.points) - 1) if isinstance(part, shapes.Bend) else 0.0
            for (start, end), (first, last) in zip(pairwise(axis.points), pairwise(axis.radii), strict=True):
                length, position, rotation = _frame_chord(start, end)
                length += (first + last) * np.tan(0.5 * turn)
                bores.append(Bore(length, 0.5 * (first + last), position, rotation, CHORD_PLANKS, hidden))
    return bores


def make_wall(pipe: Pipe) -> Wall | None:
    """Return the wall of a pipe, ``None`` in open water; that of a pipe with parts is in the world frame."""
    if pipe.is_open:
        return None
    if pipe.straight is not None:
        bore = make_bore(pipe.straight)
        return Wall(make_tube(bore.length, bore.radius, bore.thickness), bore.position, bore.rotation)
    mesh = make_parts_mesh(pipe, RELATIVE_THICKNESS * pipe.layout.narrowest)
    return Wall(mesh, np.zeros(3), np.eye(3))


def make_bore(segment: Segment) -> Bore:
    """Return a segment of a scenario's pipe with its frame."""
    length, position, rotation = _frame_chord(np.array(segment.start), np.array(segment.end))
    return Bore(length, segment.radius, position, rotation)


def _frame_chord(start: FloatArray, end: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Return length, middle and axes (columns) of a bore between two points."""
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length
    # Any direction across will do; the axis of the world with the smallest component is far from parallel.
    across = np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis)
    across /= np.linalg.norm(across)
    rotation = np.column_stack((axis, across, np.cross(axis, across)))
    return length, (start + end) / 2, rotation
