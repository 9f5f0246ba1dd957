"""The pipe for other simulators: a ring of planks for collisions, and a tube for display."""

from dataclasses import dataclass

import numpy as np

from driftform.scenario import Segment
from driftform.types import FloatArray
from driftform_robotics.models.meshes import Mesh, make_tube

PLANKS = 64
"""Number of planks around the bore: their faces lie within 0.08 % of its radius from the circle."""

RELATIVE_THICKNESS = 0.02
"""Thickness of the wall, relative to the radius of the bore."""


@dataclass(frozen=True, eq=False)
class Plank:
    """A box: ``size`` along its own axes (m), ``position`` (m) and ``rotation`` (3, 3) in the pipe's frame."""

    size: FloatArray
    position: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, eq=False)
class Bore:
    """A straight pipe about the x axis of its frame, whose origin is the middle of the pipe.

    ``position`` (m) and ``rotation`` (3, 3) give that frame in the world.
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
        """Return the wall as one closed mesh."""
        return make_tube(self.length, self.radius, self.thickness)

    def make_planks(self) -> list[Plank]:
        """Return the wall as boxes, because programs replace a mesh by its convex hull, which is solid for a pipe.

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
    """Return a segment of a scenario's pipe with its frame."""
    start, end = np.array(segment.start), np.array(segment.end)
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length
    # Any direction across will do; the axis of the world with the smallest component is far from parallel.
    across = np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis)
    across /= np.linalg.norm(across)
    rotation = np.column_stack((axis, across, np.cross(axis, across)))
    return Bore(length, segment.radius, (start + end) / 2, rotation)
