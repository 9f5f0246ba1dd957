"""Mass properties of a printed agent, combined from masses along its axis."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from driftform.agent.mass import hull_moments
from driftform.agent.solids import solid_of_revolution
from driftform.types import Agent, Body, Moments, Pocket


@dataclass(frozen=True)
class MassElement:
    """A mass on the axis.

    Attributes:
        mass: kg.
        x: of its centre in the body frame, m.
        axial, transverse: its inertia about the axis, and about a transverse axis through its centre, kg m2.
    """

    mass: float
    x: float
    axial: float = 0.0
    transverse: float = 0.0

    @classmethod
    def of_ball(cls, mass: float, x: float, radius: float) -> "MassElement":
        """Return a homogeneous sphere, kg and m: 2/5 m R^2 about any axis through its centre."""
        inertia = 0.4 * mass * radius**2
        return cls(mass, x, inertia, inertia)

    @classmethod
    def of_agent(cls, agent: Agent) -> "MassElement":
        """Return all that an agent weighs."""
        mass = agent.mass
        return cls(mass.mass, float(mass.cog[0]), float(mass.inertia[0, 0]), float(mass.inertia[1, 1]))

    @classmethod
    def of_hull(cls, body: Body, mass: float, x: float | None = None) -> "MassElement":
        """Return ``mass`` (kg) of hull, spread as its material is; about ``x`` (m), or about the centre of the material."""
        solid = hull_moments(body)
        return replace(cls._of_solid(solid, mass / solid.volume), mass=mass, x=solid.centroid if x is None else x)

    @classmethod
    def of_putty(cls, pocket: Pocket, filled: float | None = None) -> "MassElement":
        """Return the putty that fills a share of a trim pocket, from its tip on; by default that of the design."""
        share = pocket.filled if filled is None else filled
        return cls._of_solid(solid_of_revolution(pocket.contour(share)), pocket.density)

    @classmethod
    def _of_solid(cls, solid: Moments, density: float) -> "MassElement":
        across = solid.transverse - solid.volume * solid.centroid**2
        return cls(density * solid.volume, solid.centroid, density * solid.polar, density * across)

    @classmethod
    def of_print(cls, body: Body, mass: float, x: float | None = None) -> "tuple[MassElement, MassElement]":
        """Return the hull and the core of a printed agent that weigh ``mass`` (kg) together, without ballast and putty.

        ``x`` is the centre of gravity of both (m); without it, the hull's centre is that of its material. The hull's
        inertia is proportional to its mass: the distribution of the material is taken to be unchanged. Raises
        ValueError if no mass is left for the hull.
        """
        core = body.core
        hull = mass - core.mass
        if not hull > 0:
            raise ValueError(f"{mass:g} kg is not more than the core's {core.mass:g} kg alone")
        element = cls.of_hull(body, hull, None if x is None else (mass * x - core.mass * core.cog) / hull)
        return element, cls(core.mass, core.cog, *core.inertia)

    @staticmethod
    def reweigh(agent: Agent, elements: "Iterable[MassElement]") -> Agent:
        """Return the agent with the mass properties of elements as one body (Steiner).

        Its shape is unchanged, and so are its coefficients, what it displaces, and its moment across the axis. Raises ValueError
        if their mass is not above zero.
        """
        elements = list(elements)
        mass = sum(element.mass for element in elements)
        if not mass > 0:
            raise ValueError(f"a body needs a mass above 0, not {mass:g} kg")
        x = sum(element.mass * element.x for element in elements) / mass
        axial = sum(element.axial for element in elements)
        transverse = sum(element.transverse + element.mass * (element.x - x) ** 2 for element in elements)
        inertia = np.diag([axial, transverse, transverse])
        aside = agent.mass.cog[1:] * (agent.mass.mass / mass)
        return replace(agent, mass=replace(agent.mass, mass=mass, cog=np.array([x, *aside]), inertia=inertia))
