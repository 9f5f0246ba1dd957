"""Homogeneous solids, and the hull of a vehicle that was measured, for tests."""

import numpy as np

from driftform.agent import solid_of_revolution
from driftform.testing.bodies import make_body
from driftform.types import Agent, MassProperties


def solid_agent(body, density, coefficients, offset=0.0):
    """Return the agent of a homogeneous solid with the contour of ``body``.

    Args:
        density: mean density, kg/m3.
        offset: distance of the centre of gravity ahead of that of the volume, m; the inertia remains that of the
            solid.
    """
    solid = solid_of_revolution(body.outer)
    mass, transverse = density * solid.volume, solid.transverse - solid.volume * solid.centroid**2
    centre = np.array([solid.centroid, 0.0, 0.0])
    inertia = density * np.diag([solid.polar, transverse, transverse])
    return Agent(
        body, MassProperties(mass, centre + np.array([offset, 0.0, 0.0]), inertia, solid.volume, centre), coefficients
    )


def remus_body(edges=40):
    """Return the bare hull of the vehicle REMUS 100, 1.333 m long and 0.191 m thick, with ``edges`` each for bow and stern.

    Myring's profile with a little of nose and tail cut off (Prestero, Verification of a six-degree of freedom
    simulation model for the REMUS autonomous underwater vehicle, MIT 2001, eq. 2.1 and 2.2, table 2.1). The origin
    is the thesis's, 0.611 m behind the nose.
    """
    a, b, c, d, theta = 0.191, 0.654, 0.541, 0.191, 0.436
    blunt, cut = 0.0165, 0.0368
    # Distances from the nose: the bow has shorter edges where it is steep; the stern follows the middle body.
    bow = (a - blunt) * (1 - np.cos(np.linspace(0, np.pi / 2, edges + 1)))
    stern = np.linspace(0, c - cut, edges + 1)
    slope = np.tan(theta)
    r = np.concatenate(
        [
            d / 2 * np.sqrt(1 - ((bow + blunt - a) / a) ** 2),
            d / 2 - (3 * d / (2 * c**2) - slope / c) * stern**2 + (d / c**3 - slope / c**2) * stern**3,
        ]
    )
    x = 0.611 - np.concatenate([bow, a + b - blunt + stern])
    return make_body([(x[-1], 0.0), *zip(x[::-1], r[::-1], strict=True), (x[0], 0.0)])


def reciprocity(solution):
    """The error of the discretisation by panels: abs(A26 - A62) / sqrt(A22 A66); meaningless for a sphere about its centre."""
    return abs(solution.sway_of_yaw - solution.yaw_of_sway) / float(np.sqrt(solution.sway * solution.yaw))
