"""Fixtures that the tests of plugins share with those of driftform."""

from program import call, ideal_water, install, refused

__all__ = ["call", "ideal_water", "install", "refused"]
