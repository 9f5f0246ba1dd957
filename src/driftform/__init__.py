"""driftform: evolve the shape of a passive underwater agent so that the current alone carries it.

The data flow is ``genome -> morphology -> body -> coefficients -> trajectory -> fitness``;
``driftform.pipeline`` reads top to bottom like that line. Importing this package imports nothing heavy: what it
offers to notebooks and scripts is imported when it is first asked for.
"""

import lazy_loader

__version__ = "0.2.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
