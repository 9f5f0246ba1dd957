"""Body -> mass, centre of gravity, inertia, displaced volume, centre of buoyancy (eq. 11 to 24, corrected)."""

import numpy as np

from driftform.agent.solids import solid_of_revolution
from driftform.types import Body, MassProperties, Moments


def hull_moments(body: Body) -> Moments:
    """Return the volume integrals of the hull's material: its wall and its fittings."""
    return wall_moments(body) + body.fittings.material


def hull_mass(body: Body) -> float:
    """Return the mass of the hull's material, kg (eq. 24)."""
    return hull_moments(body).volume * body.hull_density


def wall_moments(body: Body) -> Moments:
    """Return the volume integrals of a hull's wall: outer contour less cavity, without fittings."""
    return displaced_moments(body) - solid_of_revolution(body.cavity)


def displaced_moments(body: Body) -> Moments:
    """Return the volume integrals of the inside of a body's outer contour."""
    return solid_of_revolution(body.outer)


def mass_properties(body: Body, parts: Moments | None = None) -> MassProperties:
    """Return the mass properties of a body with its core, and the volume that it displaces.

    The hull is outer minus cavity, and its fittings, at the hull's density (eq. 17, 18, 24). The core enters
    eq. 20 with its mass, and the inertia with its own, 2/5 m R^2 for a sphere; so does the ballast at its place. Buoyancy
    acts on the outer contour (eq. 19, 21): the hull is watertight, so it displaces the volume that it encloses, less what it
    loses under pressure.

    Args:
        body: the body.
        parts: volume integrals of the material of its parts, in place of the hull with its fittings.
    """
    hull, displaced = parts, displaced_moments(body)
    if hull is None:
        hull, displaced = hull_moments(body), displaced + body.fittings.displaced
    core, (core_axial, core_transverse) = body.core, body.core.inertia
    ballast, density = body.ballast, body.ballast_density
    mass = hull.volume * body.hull_density + core.mass + ballast.volume * density
    cog = (hull.first * body.hull_density + ballast.first * density + core.mass * core.cog) / mass
    axial = hull.polar * body.hull_density + core_axial + ballast.polar * density
    transverse = hull.transverse * body.hull_density + core_transverse + ballast.transverse * density
    transverse += core.mass * core.cog**2 - mass * cog**2
    return MassProperties(
        mass=mass,
        cog=np.array([cog, 0.0, 0.0]),
        inertia=np.array([[axial, 0.0, 0.0], [0.0, transverse, 0.0], [0.0, 0.0, transverse]]),
        volume=displaced.volume * (1 - body.squeeze),
        cob=np.array([displaced.centroid, 0.0, 0.0]),
    )
