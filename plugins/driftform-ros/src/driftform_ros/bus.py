"""What a live flight needs of ROS; :class:`driftform_ros.rospy_bus.RospyBus` has it from rospy.

Messages cross it as bytes, in the encoding of :class:`driftform_robotics.recording.messages.Messages`: publishers of rclpy
take serialized messages too.
"""

from collections.abc import Callable
from typing import Protocol


class Bus(Protocol):
    """A connection to ROS, whose callbacks run in threads of its own.

    Attributes:
        address: of the master, or what else names the network.
        has_clock: whether the flight publishes the time of ROS.
    """

    address: str
    has_clock: bool

    def advertise(self, topic: str, kind: str, latched: bool) -> None:
        """Make a topic known, whose messages are of a kind such as ``nav_msgs/Odometry``."""

    def publish(self, topic: str, message: bytes) -> None:
        """Send a message of a topic that is known."""

    def receive_currents(self, take: Callable[[tuple[float, float, float]], None]) -> None:
        """Let ``take`` have the velocity of each message of ``hydrodynamics/current_velocity``, world frame, m/s."""

    def serve(self, name: str, answer: Callable[[], tuple[bool, str]]) -> None:
        """Offer a service without arguments that answers by success and a message."""

    def read_parameter(self, name: str) -> str | None:
        """Return a parameter as text, ``None`` if it is not set."""

    def read_time(self) -> float:
        """Return the time of ROS, s."""

    def is_alive(self) -> bool:
        """Return whether ROS still answers."""
