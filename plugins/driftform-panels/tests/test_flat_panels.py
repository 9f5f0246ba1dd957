"""Panels against flat ones in three dimensions, which know nothing of rings: no elliptic integral, no curve.

The surface is cut into plane quadrilaterals of constant potential, whose integrals have closed forms (Hess & Smith
1967): the single layer by logarithms over the edges, the double layer by the solid angle. They are the same in each of
the wedges around the axis, so that the unknowns are those of one wedge.
"""

from itertools import pairwise

import numpy as np
import pytest

from driftform.agent import solid_of_revolution
from driftform_panels.solve import solve

CUP = [(0, 0), (0, 2), (6, 2), (6, 1.4), (2, 1.4), (2, 0)]
BICONE = [(0, 0), (1, 1), (3, 0.5), (4, 1.5), (4, 0)]
DISC = [(0, 0), (0, 2), (0.8, 2), (0.8, 0)]


def cut(contour, longest):
    """The contour with its edges cut into pieces of ``longest`` on average, or less, that get shorter at both ends."""
    points = [np.array(contour[:1], dtype=float)]
    for a, b in pairwise(np.array(contour, dtype=float)):
        count = int(np.ceil(np.hypot(*(b - a)) / longest - 1e-9))
        points.append(a + (b - a) * (1 - np.cos(np.pi * np.arange(1, count + 1)[:, None] / count)) / 2)
    return np.concatenate(points)


def wedge(contour, longest, around):
    """Corners of the quadrilaterals of one wedge, (n, 4, 3), with the axis along z and the centroid at z = 0."""
    points = cut(contour, longest)
    half = np.pi / around
    # Polygons of the same area as the circles that they replace.
    r = points[:, 1] * np.sqrt(half / (np.sin(half) * np.cos(half)))
    z = points[:, 0] - solid_of_revolution(contour).centroid
    right, left = (np.column_stack([r * np.cos(a), r * np.sin(a), z]) for a in (-half, half))
    return np.stack([right[:-1], left[:-1], left[1:], right[1:]], axis=1)


def layers(corners, normals, points):
    """Integrals of 1 / R and of its derivative along the normal over quadrilaterals, from points, (points, n) each."""
    to = corners[None] - points[:, None, None]
    distance = np.linalg.norm(to, axis=3)
    angle = np.zeros(distance.shape[:2])
    for b, c in ((1, 2), (2, 3)):
        # Van Oosterom & Strackee 1983: the solid angle of a triangle.
        x, y, z = to[:, :, 0], to[:, :, b], to[:, :, c]
        p, q, s = distance[:, :, 0], distance[:, :, b], distance[:, :, c]
        volume = (x * np.cross(y, z)).sum(axis=2)
        angle += 2 * np.arctan2(
            volume, p * q * s + (x * y).sum(axis=2) * s + (x * z).sum(axis=2) * q + (y * z).sum(axis=2) * p
        )
    in_plane = np.abs((to[:, :, 0] * normals).sum(axis=2)) < 1e-12
    angle[in_plane] = 0.0
    single = -np.abs((to[:, :, 0] * normals).sum(axis=2) * angle)
    for a in range(4):
        b = (a + 1) % 4
        edge = corners[:, b] - corners[:, a]
        length = np.linalg.norm(edge, axis=1)
        outward = np.cross(edge, normals) / np.where(length > 0, length, 1.0)[:, None]
        ends = distance[:, :, a] + distance[:, :, b]
        with np.errstate(divide="ignore", invalid="ignore"):
            logarithm = np.log((ends + length) / (ends - length))
        single += np.where(length > 0, (to[:, :, a] * outward).sum(axis=2) * logarithm, 0.0)
    return single, -angle


def added_mass(contour, longest, around):
    """A11, A22, A66 and the mean of A26 and A62 about the centroid, for density 1."""
    corners = wedge(contour, longest, around)
    areas = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2
    sizes = np.linalg.norm(areas, axis=1)
    normals = areas / sizes[:, None]
    aft, fore = (np.linalg.norm(corners[:, b] - corners[:, a], axis=1) for a, b in ((0, 1), (3, 2)))
    share = ((aft + 2 * fore) / (3 * (aft + fore)))[:, None]
    centres = (corners[:, 0] + corners[:, 1]) / 2 * (1 - share) + (corners[:, 3] + corners[:, 2]) / 2 * share
    single, double = np.zeros((2, 2, len(sizes), len(sizes)))
    for k in range(around):
        cos, sin = np.cos(2 * np.pi * k / around), np.sin(2 * np.pi * k / around)
        turned = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
        s, d = layers(corners @ turned, normals @ turned, centres)
        single += np.multiply.outer([1.0, cos], s)
        double += np.multiply.outer([1.0, cos], d)
    np.testing.assert_allclose(double[0].sum(axis=1), -2 * np.pi, rtol=1e-9)
    surge, sway = normals[:, 2], normals[:, 0]
    yaw = centres[:, 2] * normals[:, 0] - centres[:, 0] * normals[:, 2]
    matrices = 2 * np.pi * np.eye(len(sizes)) - double
    by_surge = np.linalg.solve(matrices[0], -single[0] @ surge)
    by_sway, by_yaw = np.linalg.solve(matrices[1], -single[1] @ np.column_stack([sway, yaw])).T
    # The mean over the circle of the square of the cosine is 1/2.
    size = -around * sizes
    return np.array(
        [
            size @ (by_surge * surge),
            size @ (by_sway * sway) / 2,
            size @ (by_yaw * yaw) / 2,
            size @ (by_yaw * sway + by_sway * yaw) / 4,
        ]
    )


@pytest.mark.parametrize(
    ("contour", "longest"), [(CUP, 0.2), (BICONE, 0.1), (DISC, 0.1)], ids=["cup", "bicone", "disc"]
)
def test_panels_agree_with_flat_panels(contour, longest):
    coarse, fine = added_mass(contour, longest, 32), added_mass(contour, longest / 2, 64)
    solution = solve(contour)
    coupling = (solution.sway_of_yaw + solution.yaw_of_sway) / 2
    actual = np.array([solution.surge, solution.sway, solution.yaw, coupling])
    unit = np.array([solution.surge, solution.sway, solution.yaw, np.sqrt(solution.sway * solution.yaw)])
    # The error of flat panels falls nearly with the square of their size.
    limit = fine + (fine - coarse) / 3
    assert np.abs((fine - limit) / unit).max() < 0.01
    np.testing.assert_allclose(actual / unit, limit / unit, rtol=0, atol=3e-3)
