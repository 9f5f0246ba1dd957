"""Solvers of the equations of motion: methods, step control, events within a step, and the error of a flight."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
