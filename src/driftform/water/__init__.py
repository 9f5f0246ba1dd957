"""The environment as data: pipe, flow, fluid, release, contact, targets, and their disturbances."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
