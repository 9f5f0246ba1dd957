"""The parts of a pipe, as data and as kernels: straights, bends, reducers, tees and grids; their walls and their flow."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
