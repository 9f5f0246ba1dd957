"""Body -> mass, centre of gravity, inertia, displaced volume, centre of buoyancy (eq. 11 to 24, corrected)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from driftform.agent.solids import solid_of_revolution
from driftform.types import Body, Detail, MassProperties, Moments


def hull_moments(body: Body) -> Moments:
    """Return the volume integrals of the hull's material: outer contour less cavity and trim pockets, and its fittings."""
    holes = (body.cavity, *(pocket.contour() for pocket in body.pockets))
    wall = sum((Moments() - solid_of_revolution(hole) for hole in holes), solid_of_revolution(body.outer))
    return sum((detail.moments for detail in body.fittings.details), wall + body.fittings.material)


def hull_mass(body: Body) -> float:
    """Return the mass of the hull's material, kg (eq. 24)."""
    return hull_moments(body).volume * body.hull_density


def mass_properties(body: Body) -> MassProperties:
    """Return the mass properties of a body with its core, and the volume that it displaces.

    The hull is outer minus cavity, and its fittings, at the hull's density (eq. 17, 18, 24). The core enters
    eq. 20 with its mass, and the inertia with its own, 2/5 m R^2 for a sphere; so do ballast and O-rings at their place. Buoyancy
    acts on the outer contour (eq. 19, 21): the hull is watertight, so it displaces the volume that it encloses, less what it
    loses under pressure. Water that stands in trim pockets, and before an O-ring, neither weighs nor displaces anything, and its
    inertia is left out.
    """
    if body.fittings.details:
        bare = replace(body, fittings=replace(body.fittings, details=()))
        return _add_details(mass_properties(bare), body.fittings.details, body.hull_density)
    hull, displaced, seals = hull_moments(body), solid_of_revolution(body.outer), body.fittings.seals
    displaced = displaced - body.fittings.flooded
    for pocket in body.pockets:
        displaced = displaced - (
            solid_of_revolution(pocket.contour()) - solid_of_revolution(pocket.contour(pocket.filled))
        )
    core, (core_axial, core_transverse) = body.core, body.core.inertia
    ballast, density = body.ballast, body.ballast_density
    putty = [(solid_of_revolution(pocket.contour(pocket.filled)), pocket.density) for pocket in body.pockets]
    # In the order of earlier versions: another one changes the last digits of flights.
    mass = hull.volume * body.hull_density + core.mass + ballast.volume * density
    mass += sum(solid.volume * heavy for solid, heavy in putty) + seals.volume
    first = hull.first * body.hull_density + ballast.first * density + core.mass * core.cog
    cog = (first + sum(solid.first * heavy for solid, heavy in putty) + seals.first) / mass
    axial = hull.polar * body.hull_density + core_axial + ballast.polar * density
    axial += sum(solid.polar * heavy for solid, heavy in putty) + seals.polar
    transverse = hull.transverse * body.hull_density + core_transverse + ballast.transverse * density
    transverse += sum(solid.transverse * heavy for solid, heavy in putty) + seals.transverse
    transverse += core.mass * core.cog**2 - mass * cog**2
    return MassProperties(
        mass=mass,
        cog=np.array([cog, 0.0, 0.0]),
        inertia=np.array([[axial, 0.0, 0.0], [0.0, transverse, 0.0], [0.0, 0.0, transverse]]),
        volume=displaced.volume * (1 - body.squeeze),
        cob=np.array([displaced.centroid, 0.0, 0.0]),
    )


def _add_details(bare: MassProperties, details: Sequence[Detail], density: float) -> MassProperties:
    """Return mass properties with those of details of a density (kg/m3), which may lie anywhere round the axis."""
    centre, displaced = np.array([1.0, *bare.cog]), bare.volume * np.array([1.0, *bare.cob])
    whole = bare.mass * np.outer(centre, centre)
    whole[1:, 1:] += np.trace(bare.inertia) / 2 * np.eye(3) - bare.inertia
    for detail in details:
        whole += density * detail.material
        displaced += detail.displaced[0]
    mass, cog = float(whole[0, 0]), whole[0, 1:] / whole[0, 0]
    spread = whole[1:, 1:] - mass * np.outer(cog, cog)
    inertia = np.trace(spread) * np.eye(3) - spread
    return MassProperties(mass, cog, inertia, float(displaced[0]), displaced[1:] / displaced[0])
