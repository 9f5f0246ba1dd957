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
    # The mobility 1 / m of a push: see driftform.motion.impact.spring.
    ("axial", float),
    ("lateral", float),
    ("turning", float),
    ("coupling", float),
    ("greatest_mass", float),  # kg
    ("frequency", float),  # rad/s
    ("dry_loss", float),
    ("wet_loss", float),  # kg m/s
)
"""The law of a contact: see :func:`driftform.motion.impact.contact_law`."""

PLANE = _lay_out(
    # Weight less buoyancy, N, and its moments about the origin from heights and from lengths along the body, N m.
    ("net_weight", float),
    ("hanging", float),
    ("trim", float),
    # The water's velocity, (x, z), m/s; that of a profile is in the next three: kind, speed, parameter.
    ("stream", float, (2,)),
    ("profile", float),
    ("speed", float),
    ("parameter", float),
    # The bore: its radius and length, the distance from its axis beyond which a surface may touch, m; in the world frame, the
    # unit vector across it and a point on its axis, (x, z).
    ("radius", float),
    ("length", float),
    ("near", float),
    ("across", float, (2,)),
    ("inlet", float, (2,)),
    # Drag, with densities, viscosity and the narrowness of the bore multiplied in.
    ("is_dragged", float),
    ("shear_mass", float),
    ("friction_area", float),
    ("friction_rate", float),
    ("ahead", float),
    ("astern", float),
    ("round_area", float),
    ("round_rate", float),
    # Of the tail: x and area for motion ahead, and astern.
    ("tails", float, (4,)),
    # Of creeping: force over velocity along and across (N s/m), torque over rate (N m s), share of the curl.
    ("creeping", float, (4,)),
    # Rows of x and the force over the velocity (m/s) and over its root, each times the velocity; the strips of a body must
    # be as many.
    ("strips", float, (5, 3)),
)
"""What follows from the other numbers for a motion in the vertical plane: see :mod:`driftform.motion.plane`."""

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
    # Contact: greatest distance of a surface from the origin, coefficient of friction, law.
    ("reach", float),
    ("friction", float),
    ("law", LAW),
    ("plane", PLANE),
)
"""About the body's origin and in body axes unless noted otherwise; SI units."""
