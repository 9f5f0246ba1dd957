"""Exact geometry of bodies of revolution: from contours to volumes, centroids and inertia."""

from driftform.agent.distance import distance_from, radii_at, radius_at
from driftform.agent.mass import displaced_moments, hull_mass, hull_moments, hull_volume, mass_properties
from driftform.agent.solids import solid_of_revolution

__all__ = [
    "displaced_moments",
    "distance_from",
    "hull_mass",
    "hull_moments",
    "hull_volume",
    "mass_properties",
    "radii_at",
    "radius_at",
    "solid_of_revolution",
]
