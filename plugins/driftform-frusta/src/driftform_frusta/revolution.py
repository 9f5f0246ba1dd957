"""Profile in the meridian half-plane -> the closed surfaces that it sweeps about the axis.

A surface of revolution takes no modelling: each point of the profile sweeps a ring of vertices, or is a pole on the
axis, and two neighbours are joined by a band of triangles. So the mesh is closed by the way it is numbered, each
vertex is where the profile has it to the last bit, and two profiles that share a point share its ring.

Circles become regular polygons, the first corner on the x axis. A regular N-gon in a circle of radius r has the area
``N/2 sin(2 pi/N) r^2``, less than the circle's; every radius is therefore scaled by :func:`area_factor`, so that each
cross-section normal to the axis has the circle's area and a mesh has the volume, and the mass, that the closed forms
give. The corners then lie outside the circle, by 0.08 % of the radius at 64 segments.
"""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np

from driftform.agent import revolve
from driftform.agent.meshes import signed_volume
from driftform.types import FloatArray
from driftform_frusta.boundary import Solid


def revolve_profiles(profiles: Iterable[FloatArray], segments: int) -> Solid:
    """Return the solid that closed profiles sweep about the z axis.

    Parameters
    ----------
    profiles
        each a polygon (n, 2) of (r, z) in mm with r >= 0, the last point joined to the first; counterclockwise
        around matter, clockwise around a hollow. They neither cross each other nor themselves.
    segments
        corners of every circle.

    Raises
    ------
    WorkFailedError
        if the solid is empty or inside out.
    """
    vertices, triangles, shells, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], [], 0
    for profile in profiles:
        for line, closed in _split_at_axis(profile):
            points, corners = revolve(line, segments, closed)
            vertices.append(points)
            triangles.append(corners + count)
            shells.append(signed_volume(points, corners))
            count += len(points)
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
