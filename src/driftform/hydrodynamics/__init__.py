"""Drag of bodies of revolution: formulas with their sources, and the drag of a whole body."""
