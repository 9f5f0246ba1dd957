"""Checks of printable files, by their meshes and by the programs of a maker."""
