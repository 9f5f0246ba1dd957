"""Which end of a part is printed on the bed: the one with less overhang, then the larger contact area."""

import math
from collections.abc import Sequence

import numpy as np

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

    def burden(up: int) -> tuple[bool, float, float]:
        foot, overhang = _measure_areas(polygons, up)
        return foot < FOOT, round(overhang, 1), -foot

    return burden(-1) < burden(1)


def overhang_area(polygons: Sequence[Ring], fore_down: bool) -> float:
    """Return the area that overhangs by more than 45 degrees, mm2, in a part printed this way up."""
    return _measure_areas(polygons, -1 if fore_down else 1)[1]


def _measure_areas(polygons: Sequence[Ring], up: int) -> tuple[float, float]:
    """Area of a part on the bed, and area that hangs in the air, mm2, with ``up`` (the sign of z) upward."""
    # Turned over, a ring runs the other way round.
    rings = [ring if up > 0 else ring[::-1] * (1.0, -1.0) for ring in polygons]
    level = min(float(ring[:, 1].min()) for ring in rings) + _LEVEL
    foot = overhang = 0.0
    for ring in rings:
        # From the last point, round the ring, to the first one again.
        corners = np.concatenate((ring[-1:], ring, ring[:1])).T
        before, here, after = corners[:, :-2], corners[:, 1:-1], corners[:, 2:]
        (r, z), (dr, dz), (dr_before, dz_before) = here, after - here, here - before
        size = np.hypot(dr, dz)
        area = np.pi * (2 * r + dr) * size
        flat = (z < level) & (after[1] < level)
        # Counterclockwise round the material, an edge's outward normal is (dz, -dr).
        hangs = (dr > math.sin(MAX_OVERHANG) * size) & ~flat
        convex = dr * dz_before - dz * dr_before < 0
        begins = (z < before[1] - 1e-9) & (dz > 1e-9) & (z > level) & convex
        foot += float(area[flat].sum())
        overhang += float(area[hangs].sum() + 2 * np.pi * _LINE * r[begins].sum())
    return foot, overhang
