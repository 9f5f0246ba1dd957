"""Options of sensors, which the fitness ``leak`` and the recorders share, and of recorded flights."""

from typing import Literal

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


Release = Literal["humble", "iron", "jazzy", "kilted", "lyrical"]


class FlightOptions(SensorOptions):
    """Options of the messages of a flight."""

    namespace: str = option(
        "agent", "namespace of topics and frames", "", min_length=1, pattern=r"^[A-Za-z][A-Za-z0-9_]*$"
    )
    start: float = option(
        1.0, "time of the release on the clock of the file; tf reads 0 as 'the latest'", "s", ge=0, le=4e9
    )
    rep105: bool = option(
        False,
        "frames by REP 105: 'map', and 'odom' and 'base_link' in the namespace; instead of 'world' for the first two",
    )
    leak_rate: float = option(0.001, "mass flow into the pipe at each target on the wall", "kg/s", ge=1e-9, le=1000)
    atmosphere: float = option(ATMOSPHERE, "pressure at the surface of the water", "Pa", ge=0, le=1e9)
    acceleration_noise: float = option(0.0, "standard deviation of the accelerometer", "m/s2", ge=0, le=1e3)
    rate_noise: float = option(0.0, "standard deviation of the gyroscope", "rad/s", ge=0, le=1e3)
    pressure_noise: float = option(0.0, "standard deviation of the pressure", "Pa", ge=0, le=1e9)
    distance_noise: float = option(0.0, "standard deviation of the distances", "m", ge=0, le=1e3)
    concentration_noise: float = option(0.0, "standard deviation of the concentration", "kg/m3", ge=0, le=1e3)
    seed: int = option(0, "seed of the noise", ge=0, le=2**63 - 1)

    @property
    def world(self) -> str:
        """The frame of the pipe."""
        return "map" if self.rep105 else "world"


class Ros2Options(FlightOptions):
    """Options of messages of ROS 2."""

    release: Release = option("jazzy", "release of ROS 2 whose message definitions are used")
