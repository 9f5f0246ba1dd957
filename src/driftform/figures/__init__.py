"""Pictures as SVG text: values in, text out, the same bytes for the same values.

Each picture is one function in a module with its name: ``section.section_svg``, ``flight.flight_svg``,
``overview.overview_svg``. The other modules hold what the pictures share.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
