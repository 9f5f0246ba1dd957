"""ROS 2 by rclpy, which belongs to the system and not to the environment of driftform."""

import os
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import Any

from driftform.errors import WorkFailedError
from driftform_robotics.options import Release
from driftform_robotics.recording.messages import full_name, make_messages
from driftform_ros.currents import TOPIC, Current, turn_current

DEPTH = 100
"""Messages of a topic that wait for a slow subscriber."""

FLUSH = 0.3
"""Time for the last messages to be sent, s."""


class RclpyBus(AbstractContextManager["RclpyBus"]):
    """A node of ROS 2, as :class:`driftform_ros.rospy_bus.RospyBus` is one of ROS 1.

    Messages are bytes, encoded by ``ros`` with the definitions of a ``release``.
    """

    call, lost = "ros2 service call {} std_srvs/srv/Trigger", "ROS 2 has ended"

    def __init__(self, name: str, has_clock: bool, remaps: Sequence[str], release: Release) -> None:
        try:
            import rclpy
            import tf2_ros
            from rclpy.signals import SignalHandlerOptions
            from rosidl_runtime_py.utilities import get_message
        except ImportError as error:
            raise WorkFailedError(
                f"ROS 2 is not found by this Python: {error}; source its setup.bash, with driftform in the system's Python"
            ) from None
        self.address = f"ROS_DOMAIN_ID {os.environ.get('ROS_DOMAIN_ID', '0')}"
        self.has_clock, self.ros, self._rclpy = has_clock, make_messages(release), rclpy
        self._find_type: Callable[[str], Any] = lambda kind: get_message(full_name(kind))
        words = [word for remap in remaps for word in ("-r", remap)]
        rclpy.init(args=["--ros-args", *words] if words else [], signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node(name)
        self._node.declare_parameter("agent", "")
        self._frames, self._publishers = tf2_ros.Buffer(), dict[str, Any]()
        self._listener = tf2_ros.TransformListener(self._frames, self._node)
        threading.Thread(target=rclpy.spin, args=(self._node,), daemon=True).start()

    def __exit__(self, *_: object) -> None:
        time.sleep(FLUSH)
        self._rclpy.try_shutdown()

    def is_alive(self) -> bool:
        """Return whether ROS still runs."""
        return bool(self._rclpy.ok())

    def check_clock(self) -> None:
        """Raise WorkFailedError if another node publishes the time of ROS."""
        nodes = [found.node_name for found in self._node.get_publishers_info_by_topic("/clock")]
        if self.has_clock and len(nodes) > 1:
            raise WorkFailedError(
                f"{', '.join(sorted(nodes))} publish /clock, and two clocks would jump: give --no-clock"
            )

    def advertise(self, topic: str, kind: str, latched: bool) -> None:
        """Advertise a topic; ``kind`` is the type of its messages, such as ``nav_msgs/Odometry``."""
        from rclpy.qos import DurabilityPolicy, QoSProfile

        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        if topic not in self._publishers:
            quality = QoSProfile(depth=1 if latched else DEPTH, durability=durability)
            self._publishers[topic] = self._node.create_publisher(self._find_type(kind), topic, quality)

    def publish(self, topic: str, message: bytes) -> None:
        """Publish an encoded message on an advertised topic."""
        self._publishers[topic].publish(message)

    def receive_currents(self, world: str, take: Callable[[Current], None]) -> None:
        """Call ``take`` with the velocity (frame ``world``, m/s) of each message of :data:`~driftform_ros.currents.TOPIC`."""
        from rclpy.time import Time

        def receive(message: Any) -> None:
            if (current := turn_current(message, world, self._frames, Time())) is not None:
                take(current)

        self._node.create_subscription(self._find_type("geometry_msgs/TwistStamped"), TOPIC, receive, DEPTH)

    def serve(self, name: str, answer: Callable[[], tuple[bool, str]]) -> None:
        """Offer a service of the type ``std_srvs/srv/Trigger``."""
        from std_srvs.srv import Trigger

        def respond(_: Any, response: Any) -> Any:
            response.success, response.message = answer()
            return response

        self._node.create_service(Trigger, name, respond)

    def read_parameter(self, name: str) -> str | None:
        """Return a parameter of the node as text, ``None`` if it is not set; ROS 2 knows it without the namespace."""
        return str(self._node.get_parameter(name.rpartition("/")[2]).value) or None

    def read_time(self) -> float:
        """Return the time of ROS, s."""
        return 1e-9 * float(self._node.get_clock().now().nanoseconds)
