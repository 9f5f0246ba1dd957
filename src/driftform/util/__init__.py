"""Files, options, ranges of formulas, progress, notebooks and compilation; independent of agents and flows."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
