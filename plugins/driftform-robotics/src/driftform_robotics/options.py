"""Options of sensors, which the fitness ``leak`` and the recorders share, and the pressure of the air."""

from driftform.interfaces import Table, option
from driftform.water import Vector

ATMOSPHERE = 101_325.0
"""Pressure at the surface of the water, Pa (standard atmosphere, ISO 2533)."""


class SensorOptions(Table):
    """Where the sensors are, and how a plume spreads."""

    sensor: Vector = option((0.0, 0.0, 0.0), "position of the sensors, body frame", "m")
    diffusivity: float | None = option(
        None,
        "turbulent diffusivity across the pipe; by default computed from the wall friction",
        "m2/s",
        ge=1e-12,
        le=1e3,
    )
