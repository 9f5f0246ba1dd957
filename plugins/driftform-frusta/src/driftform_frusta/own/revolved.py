"""A closed mesh -> the profile of the solid of revolution that it is, or how far it is from one.

The axis of a solid of revolution passes through its centroid, and is the principal axis of inertia whose moment differs
from the other two. The area of a section across it says the radius, so that volumes stay the same.
"""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from driftform.agent import distance_from
from driftform.types import FloatArray
from driftform_frusta.triangles import Mesh

if TYPE_CHECKING:
    from manifold3d import Manifold

STATIONS = 300
"""Most gaps between sections along the axis; meshes of revolved lines have a section at each ring."""

STEP = 5e-3
"""Radii on both sides of a ring that differ by more than this share of the largest are a step."""

MAX_POINTS = 160
"""Points of a contour that are kept: added mass by panels takes time in the square of their number."""

TOLERANCE = 2e-5
"""Vertices that lie within this share of the diameter from the edge that replaces them carry no shape."""


def find_profile(triangles: FloatArray, limit: float) -> tuple[FloatArray, float, tuple[float, ...]]:
    """Return the profile of a closed mesh, its deviation from a solid of revolution, and its axis.

    ``triangles`` are its corners, m, (m, 3, 3); a ValueError says the deviation, if it is more than ``limit`` over the
    diameter, or that the mesh is not closed, or several solids. The profile is distance from the nose and radius, m,
    (n, 2), and the axis a unit vector from tail to nose: the end that lies farther along the axis's greatest coordinate.
    """
    import trimesh

    corners = np.arange(3 * len(triangles)).reshape(-1, 3)
    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), corners, process=False)
    mesh.merge_vertices()
    # At a pole a modelling program leaves triangles with two corners in one place.
    mesh.update_faces((np.diff(np.sort(mesh.faces, axis=1), axis=1) > 0).all(axis=1))
    if not mesh.is_watertight:
        raise ValueError("is not a closed surface: mend it, for example with admesh or in a modelling program")
    # Without cavities, and what lies in them.
    outer = max(mesh.split(only_watertight=False), key=lambda shell: abs(shell.volume))
    if np.abs(outer.bounds - mesh.bounds).max() > 0:
        raise ValueError("holds several separate solids; a body is one: join them, or keep one")
    moments, axes = outer.principal_inertia_components, np.asarray(outer.principal_inertia_vectors)
    order = np.abs(moments - np.median(moments)).argsort()[::-1]
    # The axis last; equal moments, such as those of a ball, leave the axes of the file.
    frame = np.roll(axes, 2 - order[0], axis=0)
    frame *= np.sign(frame[2, np.abs(frame[2]).argmax()])
    points, inverted = (outer.vertices - outer.center_mass) @ frame.T, outer.volume * np.linalg.det(frame) < 0
    solid = Mesh(points, outer.faces[:, ::-1] if inverted else outer.faces).to_manifold()
    placed = points[outer.faces]
    contour = simplify_contour(_trace_contour(placed, solid))
    if not contour[:, 1].max() > 0:
        raise ValueError("has no volume")
    # Cavities are within it; other solids may stand out.
    at = (mesh.vertices - outer.center_mass) @ frame.T
    out = at[np.hypot(at[:, 0], at[:, 1]) > np.interp(at[:, 2], *contour.T)]
    every = np.concatenate([placed, np.repeat(out[:, None], 3, axis=1)])
    deviation = _measure_deviation(every, contour) / (2 * float(contour[:, 1].max()))
    if deviation > limit:
        raise ValueError(
            f"is not a solid of revolution: its surface deviates by {100 * deviation:.1f} % of the diameter from one about "
            f"the axis ({', '.join(f'{c:.3f}' for c in frame[2])}), and {100 * limit:g} % are accepted; a body must be "
            "round, and closed where it is hollow; for fins, give --coefficients"
        )
    profile = contour[::-1] * [-1.0, 1.0]
    profile[:, 0] -= profile[0, 0]
    return profile, deviation, tuple(frame[2].tolist())


def _trace_contour(placed: FloatArray, solid: "Manifold") -> FloatArray:
    """Return the contour about the third axis, from aft to fore, (n, 2): the radii of circles with the areas of sections."""
    heights = np.unique(placed[..., 2])
    rings = heights[np.append(True, np.diff(heights) > 1e-5 * (heights[-1] - heights[0]))]
    if len(rings) > STATIONS + 1:
        rings = np.linspace(heights[0], heights[-1], STATIONS + 1)
    rings[-1] = heights[-1]
    before, after = [0.0], []
    for low, high in pairwise(rings.tolist()):
        # Between two rings the radius is linear, and at one of them it may have a step.
        step = 0.02 * (high - low)
        first, last = (float(np.sqrt(solid.slice(height).area() / np.pi)) for height in (low + step, high - step))
        slope = (last - first) / (high - low - 2 * step)
        after.append(max(first - slope * step, 0.0))
        before.append(max(last + slope * step, 0.0))
    points, widest = [(rings[0], 0.0)], max(before)
    for x, low, high in zip(rings.tolist(), before, [*after, 0.0], strict=True):
        is_step = abs(low - high) > STEP * widest
        points += [(x, low), (x, high)] if is_step else [(x, (low + high) / 2)]
    contour = np.array([*points, (rings[-1], 0.0)])
    contour[contour[:, 1] < 1e-4 * widest, 1] = 0.0
    return np.asarray(contour[np.append(True, np.diff(contour, axis=0).any(axis=1))])


def _measure_deviation(placed: FloatArray, contour: FloatArray) -> float:
    """Return the greatest distance (m) of vertices, and of the middles of large triangles, from the contour."""
    large = placed[np.ptp(placed, axis=1).max(axis=1) > 0.02 * contour[:, 1].max()]
    middles = [(large + np.roll(large, 1, axis=1)).reshape(-1, 3) / 2, large.mean(axis=1)]
    points = np.concatenate([placed.reshape(-1, 3), *middles])
    flat = np.unique(np.column_stack([points[:, 2], np.hypot(points[:, 0], points[:, 1])]), axis=0)
    parts = np.array_split(flat, len(flat) // 20_000 + 1)
    return max(float(distance_from(part, contour).max()) for part in parts)


def simplify_contour(points: FloatArray) -> FloatArray:
    """Return the contour without points that carry no shape, at most :data:`MAX_POINTS`."""
    from driftform.figures.scene import simplify_polyline

    tolerance = TOLERANCE * 2 * float(points[:, 1].max())
    while len(kept := simplify_polyline(points, tolerance)) > MAX_POINTS:
        tolerance *= 1.5
    return kept
