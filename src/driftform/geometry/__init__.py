"""Exact geometry of bodies of revolution: from contours to volumes, centroids and inertia."""

from driftform.geometry.distance import distance_from, radii_at, radius_at
from driftform.geometry.mass import displaced_moments, hull_mass, hull_moments, hull_volume, mass_properties
from driftform.geometry.solids import solid_of_revolution

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
