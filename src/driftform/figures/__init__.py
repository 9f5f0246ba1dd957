"""Pictures as SVG text: values in, text out, the same bytes for the same values.

Each picture is one function in a module of its own: ``section.section_svg``, ``flight.flight_svg``,
``overview.overview_svg``. The rest of the package is what they share.
"""
