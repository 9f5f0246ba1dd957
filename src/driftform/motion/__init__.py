"""Motion of a rigid body in moving water: drag, contact, equations, solvers, and the trajectories that they give."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
