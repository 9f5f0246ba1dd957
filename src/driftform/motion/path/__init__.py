"""Paths of bodies: trajectories, what lies between their samples, and what can be measured on them; no integration."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
