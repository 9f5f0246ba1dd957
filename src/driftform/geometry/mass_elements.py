"""What a printed agent weighs: masses along the axis, put together to mass, centre of gravity and inertia."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from driftform.geometry import solid_of_revolution
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
        its own inertia about the axis, and across it through its centre, kg m2.
    """

    mass: float
    x: float
    axial: float = 0.0
    transverse: float = 0.0


def hull_element(body: Body, mass: float | None = None, x: float | None = None) -> MassElement:
    """The hull, as its material gives it, or with another ``mass`` (kg) and centre ``x`` (m).

    Its inertia goes with the mass: the material is taken to be spread as it was.
    """
    solid = solid_of_revolution(body.outer) - solid_of_revolution(body.cavity)
    mass = solid.volume * body.hull_density if mass is None else mass
    share = mass / solid.volume
    return MassElement(
        mass=mass,
        x=solid.centroid if x is None else x,
        axial=share * solid.polar,
        transverse=share * (solid.transverse - solid.volume * solid.centroid**2),
    )


def core_element(body: Body) -> MassElement:
    """The core: a homogeneous sphere at the origin."""
    return ball_element(body.core.mass, 0.0, body.core.radius)


def ball_element(mass: float, x: float, radius: float) -> MassElement:
    """A homogeneous sphere: 2/5 m R^2 about any axis through its centre."""
    inertia = 0.4 * mass * radius**2
    return MassElement(mass, x, inertia, inertia)


def combine(elements: Iterable[MassElement], like: MassProperties) -> MassProperties:
    """Elements as one body (Steiner), which displaces what ``like`` does.

    Raises
    ------
    ValueError
        where their mass is not above zero.
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
    """The hull of a printed agent that weighs ``mass`` (kg) with its core.

    ``x`` is the centre of gravity of both (m); without it the hull's is where its material has it.

    Raises
    ------
    ValueError
        where nothing, or less, is left for the hull.
    """
    hull = mass - body.core.mass
    if not hull > 0:
        raise ValueError(f"{mass:g} kg is no more than the core's {body.core.mass:g} kg alone")
    return hull_element(body, hull, None if x is None else mass * x / hull)


def reweigh(agent: Agent, mass: float, x: float | None = None) -> Agent:
    """The agent as it flies if it weighs ``mass`` (kg), its centre of gravity at ``x`` (m); see :func:`printed_hull_element`.

    Its shape, and so its coefficients, are what they were.
    """
    elements = (printed_hull_element(agent.body, mass, x), core_element(agent.body))
    return replace(agent, mass=combine(elements, agent.mass))
