"""Forces on a body in moving water: drag, buoyancy, added mass, contact, and the rate of its state; no time step."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
