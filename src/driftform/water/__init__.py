"""The water and its bounds, as data and as kernels: pipe, flow, fluid, release, targets, and their disturbances."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
