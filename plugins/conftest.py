"""Fixtures that the tests of plugins share with those of driftform."""

from pages import publish, published
from program import call, done, ideal_water, install, refused, requires_program

__all__ = ["call", "done", "ideal_water", "install", "publish", "published", "refused", "requires_program"]
