"""Drag of bodies of revolution: formulas with their sources, and what they make of a body."""
