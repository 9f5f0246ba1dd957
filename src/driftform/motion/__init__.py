"""Motion of a rigid body in moving water: compiled kernels on plain arrays, shared by every simulator."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
