"""Where the flow leaves the tail of a body of revolution: the base, and the section whose wake carries lift."""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled

SEPARATION = math.radians(20)
"""Inclination (rad) of a tail against the axis beyond which the flow separates (Hoerner, chapter 3: 15 to 20 degrees)."""

WINDOW = 0.5
"""Length, over the greatest diameter, over which the inclination of a tail is averaged to find where it is steepest."""


@compiled
def separation_point(contour: FloatArray) -> tuple[float, float]:
    """Return x and radius (m) at which the flow separates from the tail of a contour (n, 2) that moves towards +x.

    That is where the tail, from its widest point aft, is first steeper than :data:`SEPARATION`; the aft end, with radius
    zero, if it is nowhere.
    """
    first, radius = 0, 0.0
    for k in range(contour.shape[0]):
        if contour[k, 1] > radius * (1.0 + 1e-9):
            first, radius = k, contour[k, 1]
    for k in range(first, 0, -1):
        fall, along = contour[k, 1] - contour[k - 1, 1], contour[k, 0] - contour[k - 1, 0]
        if fall > 0.0 and math.atan2(fall, max(along, 0.0)) > SEPARATION:
            return contour[k, 0], contour[k, 1]
    return contour[0, 0], 0.0


def wake_section(contour: FloatArray, x: FloatArray, r: FloatArray) -> tuple[float, float]:
    """Return x (m) and area (m2) of the section where the wake of a contour that moves towards +x begins.

    It is the section at which the flow separates from the tail, or at which the tail is steepest, whichever comes first.
    Of the bare hull of SUBOFF the second lies at 0.89 of the length from the nose and has 0.27 of the greatest section, and
    the lift of this section explains the measured one (Roddy, DTRC/SHD-1298-08, 1990); for a blunt end, slender-body
    theory demands the first.

    Args:
        contour: meridian, m, (n, 2).
        x, r: the same at equal steps of ascending x, m, (k,) each.
    """
    x_base, r_base = separation_point(contour)
    widest, step = int(np.argmax(r)), float(x[1] - x[0])
    half = max(1, round(WINDOW * float(r[widest]) / step))
    # Mean inclination over the window about each station between the aft end and the widest section.
    slopes = r[2 * half : widest + 1] - r[: max(0, widest + 1 - 2 * half)]
    if len(slopes) == 0 or slopes.max() <= 0.0:
        return x_base, math.pi * r_base**2
    steep = np.flatnonzero(slopes >= 0.98 * slopes.max())
    k = half + int(steep[len(steep) // 2])
    if r_base > 0.0 and x_base >= x[k]:
        return x_base, math.pi * r_base**2
    return float(x[k]), math.pi * float(r[k]) ** 2
