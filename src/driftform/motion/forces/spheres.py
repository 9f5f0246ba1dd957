"""Homogeneous spheres: agents that do nothing but float, sink or drift."""

import numpy as np

from driftform.agent import mass_properties
from driftform.motion.forces.body_drag import estimate_drag
from driftform.types import Agent, Body, Coefficients, Core
from driftform.water import Fluid

_POINTS = 65
"""Points of the contour."""


def make_sphere(diameter: float, fluid: Fluid, buoyancy: float = 0.0) -> Agent:
    """Return a sphere with a net ``buoyancy`` (N) in a fluid; its added mass is half of that of the fluid it displaces.

    ``diameter`` is in m. The sphere is neutral by default.
    """
    radius = diameter / 2
    angle = np.linspace(0, np.pi, _POINTS)
    outer = np.column_stack([-radius * np.cos(angle), radius * np.sin(angle)])
    outer[[0, -1], 1] = 0.0

    def make_body(density: float) -> Body:
        return Body(outer, np.zeros((0, 2)), np.array([-radius, radius]), Core(0.0, 0.0), radius, density)

    displaced = mass_properties(make_body(fluid.density)).mass
    body = make_body(fluid.density * (1 - buoyancy / (fluid.gravity * displaced)))
    added = np.diag([displaced / 2] * 3 + [0.0] * 3)
    drag = estimate_drag(body, fluid.viscosity, 0.0)
    return Agent(body, mass_properties(body), Coefficients(added, drag=drag))
