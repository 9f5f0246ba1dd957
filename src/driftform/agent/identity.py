"""Which bodies are the same: modules of equal tilt side by side, in another order, make the same one."""

from dataclasses import astuple

import numpy as np

from driftform.types import Body

RESOLUTION = 1e-9
"""Coordinates of contours that differ by less than this, m, are equal but for rounding."""


def body_key(body: Body) -> bytes:
    """Return what is equal for bodies that fly alike, to be compared or hashed: all of a body but the joints of its modules.

    Contours are compared to 1e-9 m, and all masses to ten digits. Kits that are cut at other joints have other fittings.
    """
    contours = [np.round(contour / RESOLUTION).astype(np.int64) for contour in (body.outer, body.cavity)]
    moments = (body.fittings.material, body.fittings.displaced, body.ballast)
    numbers = [body.wall, body.hull_density, body.ballast_density, *astuple(body.core)]
    numbers += [value for solid in moments for value in astuple(solid)]
    written = " ".join(f"{value + 0.0:.9e}" for value in numbers)
    return b"|".join((*(contour.tobytes() for contour in contours), written.encode()))
