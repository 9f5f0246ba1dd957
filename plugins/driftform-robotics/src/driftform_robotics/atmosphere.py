"""The air above the water."""

ATMOSPHERE = 101_325.0
"""Pressure at the surface, Pa (standard atmosphere, ISO 2533)."""
