"""What may be asked of a recorded flight."""

from typing import Literal

from driftform.options import Table, option
from driftform.scenario import Vector
from driftform_robotics.atmosphere import ATMOSPHERE

Release = Literal["humble", "iron", "jazzy", "kilted", "lyrical"]

Storage = Literal["sqlite3", "mcap"]


class FlightOptions(Table):
    """What a flight's messages hold."""

    release: Release = option("jazzy", "release of ROS 2 whose message definitions are used")
    namespace: str = option(
        "agent", "of topics and frames", "", min_length=1, pattern=r"^[A-Za-z][A-Za-z0-9_]*$"
    )
    start: float = option(
        1.0,
        "time of the release on the clock of the file; 0 would mean 'the latest' to tf",
        "s",
        ge=0,
        le=4e9,
    )
    sensor: Vector = option((0.0, 0.0, 0.0), "where the sensors are in the body", "m")
    leak_rate: float = option(0.001, "what comes in at each target that lies on the wall", "kg/s", gt=0)
    diffusivity: float | None = option(
        None, "turbulent diffusivity across the pipe; by default that of its wall friction", "m2/s", gt=0
    )
    atmosphere: float = option(ATMOSPHERE, "pressure at the surface", "Pa", ge=0)
    acceleration_noise: float = option(0.0, "standard deviation of an accelerometer's reading", "m/s2", ge=0)
    rate_noise: float = option(0.0, "standard deviation of a gyroscope's reading", "rad/s", ge=0)
    pressure_noise: float = option(0.0, "standard deviation of a reading of the pressure", "Pa", ge=0)
    distance_noise: float = option(0.0, "standard deviation of a distance", "m", ge=0)
    concentration_noise: float = option(0.0, "standard deviation of a concentration", "kg/m3", ge=0)
    seed: int = option(0, "seed of the noise", ge=0)


class Rosbag2Options(FlightOptions):
    """What a bag's messages hold, and how they are stored."""

    storage: Storage = option(
        "sqlite3", "what every release of ROS 2 reads, or mcap, the default of ROS 2 since Iron"
    )
