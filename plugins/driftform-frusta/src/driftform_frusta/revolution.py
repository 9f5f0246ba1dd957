"""Profile in the meridian half-plane -> the closed surfaces that it sweeps about the axis.

A surface of revolution takes no modelling: each point of the profile sweeps a ring of vertices, or is a pole on the
axis, and two neighbours are joined by a band of triangles. So the mesh is closed by the way it is numbered, each
vertex is where the profile has it to the last bit, and two profiles that share a point share its ring.
"""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np

from driftform.types import FloatArray
from driftform_frusta.boundary import Solid
from driftform_frusta.triangles import Mesh


def revolve_profiles(profiles: Iterable[FloatArray], segments: int) -> Solid:
    """Return the solid that closed profiles sweep about the z axis.

    Args:
        profiles: each a polygon (n, 2) of (r, z) in mm with r >= 0, the last point joined to the first;
            counterclockwise around matter, clockwise around a hollow. They neither cross each other nor themselves.
        segments: corners of every circle.

    Raises WorkFailedError if the solid is empty or inside out.
    """
    vertices, triangles, shells, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], [], 0
    for profile in profiles:
        for line, closed in _split_at_axis(profile):
            mesh = Mesh.revolve(line, segments, closed)
            vertices.append(mesh.vertices)
            triangles.append(mesh.triangles + count)
            shells.append(mesh.volume)
            count += len(mesh.vertices)
    return Solid(np.concatenate(vertices), np.concatenate(triangles), np.array(shells))


def _split_at_axis(profile: FloatArray) -> Iterator[tuple[FloatArray, bool]]:
    """Split a profile where it is on the axis: lines from pole to pole, or itself, a ring, where it never is."""
    poles = np.flatnonzero(profile[:, 0] == 0)
    if not len(poles):
        yield profile, True
        return
    turned = np.roll(profile, -poles[0], axis=0)
    ends = np.append(poles - poles[0], len(profile))
    turned = np.append(turned, turned[:1], axis=0)
    for start, end in pairwise(ends):
        if end - start > 1:
            yield turned[start : end + 1], False
