"""Which end of a part is printed on the bed: the one with less overhang, then the larger contact area."""

import math
from collections.abc import Sequence

import numpy as np

from driftform.types import FloatArray
from driftform_kit.checks.slenderness import FOOT
from driftform_kit.cutting.meridian import Ring

MAX_OVERHANG = math.radians(45.0) + 1e-3
"""A surface that leans out of the vertical by more than this needs support."""

_LINE = 1.2
"""mm of overhang that an edge counts as which begins in the air."""

_LEVEL = 1e-3
"""mm: a surface lower than this is on the bed."""


def prints_fore_down(polygons: Sequence[Ring]) -> bool:
    """Return whether a part is printed with its fore end on the bed, by the rings of its half section."""
    return _burden(polygons, -1) < _burden(polygons, 1)


def _burden(polygons: Sequence[Ring], up: int) -> tuple[bool, float, float]:
    """Key to sort orientations by, with ``up`` (the sign of z) upward: unstable, overhang (mm2), less contact (mm2)."""
    foot, overhang = _measure_areas(polygons, up)
    return foot < FOOT, round(overhang, 1), -foot


def overhang_area(polygons: Sequence[Ring], fore_down: bool) -> float:
    """Return the area that overhangs by more than 45 degrees, mm2, in a part printed this way up."""
    return _measure_areas(polygons, -1 if fore_down else 1)[1]


def _measure_areas(polygons: Sequence[Ring], up: int) -> tuple[float, float]:
    """Area of a part on the bed, and area that hangs in the air, mm2."""
    lowest = min(float((up * ring[:, 1]).min()) for ring in polygons)
    foot, overhang = np.sum([_areas(ring, up, lowest) for ring in polygons], axis=0).tolist()
    return foot, overhang


def _areas(ring: Ring, up: int, lowest: float) -> FloatArray:
    """Area on the bed, and area that hangs in the air, mm2."""
    # Turned over, a ring runs the other way round.
    turned = ring if up > 0 else ring[::-1] * (1.0, -1.0)
    # From the last point, round the ring, to the first one again.
    corners = np.concatenate((turned[-1:], turned, turned[:1])).T
    before, here, after = corners[:, :-2], corners[:, 1:-1], corners[:, 2:]
    (r, z), (dr, dz), (dr_before, dz_before) = here, after - here, here - before
    size = np.hypot(dr, dz)
    area = np.pi * (2 * r + dr) * size
    flat = (z < lowest + _LEVEL) & (after[1] < lowest + _LEVEL)
    # Counterclockwise round the material, an edge's outward normal is (dz, -dr).
    hangs = (dr > math.sin(MAX_OVERHANG) * size) & ~flat
    convex = dr * dz_before - dz * dr_before < 0
    begins = (z < before[1] - 1e-9) & (dz > 1e-9) & (z > lowest + _LEVEL) & convex
    return np.array([area[flat].sum(), area[hangs].sum() + 2 * np.pi * _LINE * r[begins].sum()])
