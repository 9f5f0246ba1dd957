"""The pipe as other simulators take it: a ring of planks to collide with, and a tube to look at."""

from dataclasses import dataclass

import numpy as np

from driftform.scenario import Segment
from driftform.types import FloatArray
from driftform_robotics.models.meshes import Mesh, tube

PLANKS = 64
"""Planks around the bore: their faces lie within 0.08 % of its radius from the circle."""

RELATIVE_THICKNESS = 0.02
"""Thickness of the wall over the radius of the bore."""


@dataclass(frozen=True, eq=False)
class Plank:
    """A box: its ``size`` along its own axes (m), its ``position`` (m) and ``rotation`` (3, 3) in the pipe's frame."""

    size: FloatArray
    position: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, eq=False)
class Bore:
    """A straight piece of pipe about the x axis of its own frame, whose origin is its middle.

    ``position`` (m) and ``rotation`` (3, 3) are those of that frame in the world.
    """

    length: float
    radius: float
    position: FloatArray
    rotation: FloatArray

    @property
    def thickness(self) -> float:
        """Thickness of the wall, m."""
        return RELATIVE_THICKNESS * self.radius

    def make_mesh(self) -> Mesh:
        """The wall as one closed mesh."""
        return tube(self.length, self.radius, self.thickness)

    def make_planks(self) -> list[Plank]:
        """The wall as boxes, because a mesh of a pipe would be taken for its convex hull, which is solid.

        The polygon of their inner faces has the area of the bore.
        """
        half = np.pi / PLANKS
        apothem = self.radius * np.sqrt(half / np.tan(half))
        size = np.array([self.length, 2 * (apothem + self.thickness) * np.tan(half), self.thickness])
        axis = np.array([1.0, 0.0, 0.0])
        found = []
        for angle in 2 * half * np.arange(PLANKS):
            outward = np.array([0.0, np.cos(angle), np.sin(angle)])
            rotation = np.column_stack((axis, np.cross(outward, axis), outward))
            found.append(Plank(size, (apothem + self.thickness / 2) * outward, rotation))
        return found


def make_bore(segment: Segment) -> Bore:
    """Return a segment of a scenario's pipe with a frame of its own."""
    start, end = np.array(segment.start), np.array(segment.end)
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length
    # Any direction across will do, as long as it is well across.
    across = np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis)
    across /= np.linalg.norm(across)
    rotation = np.column_stack((axis, across, np.cross(axis, across)))
    return Bore(length, segment.radius, (start + end) / 2, rotation)
