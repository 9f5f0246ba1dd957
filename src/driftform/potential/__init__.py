"""Ideal flow in tees and wyes: wall, hierarchical splines, Galerkin's method, stored potentials."""

from driftform.potential.store import TeePotentials as TeePotentials
from driftform.potential.store import is_stored as is_stored
from driftform.potential.store import load_tee as load_tee
from driftform.potential.wall import Junction as Junction
