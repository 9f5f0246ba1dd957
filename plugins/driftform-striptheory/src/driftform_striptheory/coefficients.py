"""The paper's hydrodynamics: strip theory across the axis, the equivalent ellipsoid along it."""

from typing import Literal

import numpy as np

from driftform.agent import solid_of_revolution
from driftform.interfaces import Hydrodynamics, HydrodynamicsOptions, option
from driftform.types import Body, Coefficients
from driftform.water import Fluid
from driftform_striptheory.ellipsoid import axial_coefficient


class StripTheoryOptions(HydrodynamicsOptions):
    """Options of the strip-theory model."""

    m11: Literal["ellipsoid", "volume"] = option(
        "ellipsoid", "M11 is k11 times the mass of water in the equivalent ellipsoid (eq. 7) or in the true volume"
    )


class StripTheory(Hydrodynamics[StripTheoryOptions]):
    """Equations 1 to 10 of the paper, about the centre of buoyancy.

    The strips are the circular sections of the outer contour, m22 = m33 = rho pi r^2, so that M22, M26 and M66
    are rho times the integrals of 1, x and x^2 over the displaced volume. Therefore
    M26 vanishes about the centre of buoyancy, and M22 = rho V.
    """

    name = "striptheory"
    Options = StripTheoryOptions

    def coefficients(self, body: Body, fluid: Fluid) -> Coefficients:
        """Return the added mass about the centre of buoyancy, as in the paper."""
        displaced, length, diameter = solid_of_revolution(body.outer), body.length, body.max_diameter
        k11 = axial_coefficient(diameter / length)
        a, b = length / 2, diameter / 2
        volume = displaced.volume if self.options.m11 == "volume" else 4 / 3 * np.pi * a * b**2
        lateral = fluid.density * displaced.volume
        turning = fluid.density * (displaced.second - displaced.volume * displaced.centroid**2)
        added_mass = np.diag([fluid.density * volume * k11, lateral, lateral, 0.0, turning, turning])
        return Coefficients(added_mass, origin=np.array([displaced.centroid, 0.0, 0.0]))
