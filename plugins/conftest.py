"""Fixtures that the tests of plugins share with those of driftform."""

from program import call, ideal_water, install, refused, requires_program

__all__ = ["call", "ideal_water", "install", "refused", "requires_program"]
