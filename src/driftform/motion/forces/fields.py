"""The numbers of an agent in a scenario that the kernels read: one list of named fields."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Records: TypeAlias = npt.NDArray[np.void]
"""An array of records with the fields of one of the types below: kernels read n.gravity, Python reads n["gravity"]."""


def _lay_out(*fields: tuple[str, object] | tuple[str, object, Sequence[int]]) -> np.dtype[np.void]:
    return np.dtype(list(fields), align=True)


LAW = _lay_out(
    # The mobility 1 / m of a push: see driftform.motion.forces.impact.spring.
    ("axial", float),
    ("lateral", float),
    ("turning", float),
    ("coupling", float),
    ("greatest_mass", float),  # kg
    ("frequency", float),  # rad/s
    ("dry_loss", float),
    ("wet_loss", float),  # kg m/s
)
"""The law of a contact: see :func:`driftform.motion.forces.impact.contact_law`."""

NUMBERS = _lay_out(
    # Total mass M_RB + M_A and its inverse, linear and quadratic damping about ``damping_point``.
    ("mass", float, (6, 6)),
    ("inverse", float, (6, 6)),
    ("linear", float, (6, 6)),
    ("quadratic", float, (6, 6)),
    ("damping_point", float, (3,)),
    ("is_damped", float),
    ("is_axisymmetric", float),  # 1 if a roll changes nothing
    ("cog", float, (3,)),
    ("cob", float, (3,)),
    ("body_mass", float),
    ("displaced_mass", float),  # of the water
    # The water; its level is infinite without a free surface. It has the velocity ``current`` (world frame) where it is
    # uniform and steady.
    ("gravity", float),
    ("density", float),
    ("viscosity", float),
    ("water_level", float),
    ("current", float, (3,)),
    ("is_steady", float),
    ("has_pressure_gradient", float),  # 1 if that of accelerating water acts on the body
    # Drag: see driftform.types.Drag. Axial: friction area, length, drag areas ahead and astern. Tails: x and lift area for
    # motion ahead, and astern.
    ("axial", float, (4,)),
    ("tails", float, (4,)),
    ("round_area", float),
    ("diameter", float),
    ("centre", float),  # x of the drag of a sphere
    ("spin", float),
    ("shear_volume", float),
    ("blocking", float),
    ("creeping", float, (4,)),
    ("rubbing", float),
    # Variance of the volume, m2.
    ("spread_across", float),
    ("spread_along", float),
    # Contact: greatest distance of a surface from the origin, curvature of the wall, coefficient of friction, law.
    ("reach", float),
    ("curvature", float),  # greatest one of the wall of a pipe with parts, 1/m; 0 in a straight bore
    ("friction", float),
    ("law", LAW),
)
"""About the body's origin and in body axes unless noted otherwise; SI units."""
