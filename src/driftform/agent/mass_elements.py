"""Mass properties of a printed agent, combined from masses along its axis."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from driftform.agent.mass import hull_moments
from driftform.types import Agent, Body, MassProperties


@dataclass(frozen=True)
class MassElement:
    """A mass on the axis.

    Attributes
    ----------
    mass
        kg.
    x
        of its centre in the body frame, m.
    axial, transverse
        its inertia about the axis, and about a transverse axis through its centre, kg m2.
    """

    mass: float
    x: float
    axial: float = 0.0
    transverse: float = 0.0


def hull_element(body: Body, mass: float | None = None, x: float | None = None) -> MassElement:
    """Return the hull with the mass and centre of its material, or with another ``mass`` (kg) and centre ``x`` (m).

    Its inertia is proportional to the mass: the distribution of the material is taken to be unchanged.
    """
    solid = hull_moments(body)
    mass = solid.volume * body.hull_density if mass is None else mass
    share = mass / solid.volume
    return MassElement(
        mass=mass,
        x=solid.centroid if x is None else x,
        axial=share * solid.polar,
        transverse=share * (solid.transverse - solid.volume * solid.centroid**2),
    )


def core_element(body: Body) -> MassElement:
    """Return the core: a homogeneous sphere at the origin."""
    return ball_element(body.core.mass, 0.0, body.core.radius)


def ball_element(mass: float, x: float, radius: float) -> MassElement:
    """Return a homogeneous sphere: 2/5 m R^2 about any axis through its centre."""
    inertia = 0.4 * mass * radius**2
    return MassElement(mass, x, inertia, inertia)


def combine(elements: Iterable[MassElement], like: MassProperties) -> MassProperties:
    """Return the mass properties of elements as one body (Steiner) that displaces the same volume as ``like``.

    Raises
    ------
    ValueError
        if their mass is not above zero.
    """
    elements = list(elements)
    mass = sum(element.mass for element in elements)
    if not mass > 0:
        raise ValueError(f"a body needs a mass above 0, not {mass:g} kg")
    x = sum(element.mass * element.x for element in elements) / mass
    axial = sum(element.axial for element in elements)
    transverse = sum(element.transverse + element.mass * (element.x - x) ** 2 for element in elements)
    return replace(
        like, mass=mass, cog=np.array([x, 0.0, 0.0]), inertia=np.diag([axial, transverse, transverse])
    )


def printed_hull_element(body: Body, mass: float, x: float | None = None) -> MassElement:
    """Return the hull of a printed agent that weighs ``mass`` (kg) with its core.

    ``x`` is the centre of gravity of both (m); without it, the hull's centre is that of its material.

    Raises
    ------
    ValueError
        if no mass is left for the hull.
    """
    hull = mass - body.core.mass
    if not hull > 0:
        raise ValueError(f"{mass:g} kg is not more than the core's {body.core.mass:g} kg alone")
    return hull_element(body, hull, None if x is None else mass * x / hull)


def reweigh(agent: Agent, mass: float, x: float | None = None) -> Agent:
    """Return the agent with another ``mass`` (kg) and centre of gravity ``x`` (m); see :func:`printed_hull_element`.

    Its shape is unchanged, and so are its coefficients.
    """
    elements = (printed_hull_element(agent.body, mass, x), core_element(agent.body))
    return replace(agent, mass=combine(elements, agent.mass))


class Ballast(Protocol):
    """What hangs on an agent's outside, as :class:`driftform.water.Release` has it."""

    @property
    def ballast(self) -> float:
        """Mass, kg."""

    @property
    def ballast_x(self) -> float:
        """Where it hangs along the axis, m."""

    @property
    def ballast_density(self) -> float:
        """Density, kg/m3."""


def load_ballast(mass: MassProperties, load: Ballast) -> MassProperties:
    """Return the mass properties with a ballast that hangs on the outside of the agent, in its water.

    The ballast is a point on the axis. It displaces water of its own volume; its drag is neglected.
    """
    if load.ballast == 0.0:
        return mass
    volume, offset = load.ballast / load.ballast_density, np.array([load.ballast_x, 0.0, 0.0])
    total, displaced = mass.mass + load.ballast, mass.volume + volume
    cog = (mass.mass * mass.cog + load.ballast * offset) / total
    cob = (mass.volume * mass.cob + volume * offset) / displaced
    across = np.diag([0.0, 1.0, 1.0])
    inertia = mass.inertia + mass.mass * (mass.cog[0] - cog[0]) ** 2 * across
    inertia = inertia + load.ballast * (load.ballast_x - cog[0]) ** 2 * across
    return MassProperties(total, cog, inertia, displaced, cob)
