"""ROS 1 by rospy, which belongs to the system and not to the environment of driftform."""

import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from driftform.errors import WorkFailedError
from driftform_robotics.recording.messages import full_name, make_messages
from driftform_ros.currents import TOPIC, Current, turn_current

SYSTEM = ("opt/ros/*/lib/python3/dist-packages", "usr/lib/python3/dist-packages")
"""Where ROS 1 has its Python packages, from the root of the file system."""

QUEUE = 10_000
"""Messages of a topic that wait for a slow subscriber."""

PATIENCE = 0.5
"""Time between two checks that the master answers, s."""

FLUSH = 0.3
"""Time for the last messages to be sent, s."""


def find_rospy() -> None:
    """Make rospy importable.

    The system's packages go to the end of the path: before ours they would replace NumPy. Raises WorkFailedError if it
    is missing.
    """
    for folder in (str(path) for pattern in SYSTEM for path in sorted(Path("/").glob(pattern))):
        if folder not in sys.path:
            sys.path.append(folder)
    try:
        import rospy  # noqa: F401
        import std_srvs.srv  # noqa: F401
        import tf2_ros  # noqa: F401
    except ImportError as error:
        raise WorkFailedError(
            f"ROS 1 is not installed: {error}; on Debian: apt install python3-rospy python3-std-srvs python3-tf2-ros"
        ) from None


class RospyBus(AbstractContextManager["RospyBus"]):
    """A node of ROS 1; it ends with the context. Callbacks run in threads of rospy.

    Messages are bytes, encoded by ``ros``. ``has_clock`` is whether the flight publishes the time of ROS, ``address`` that of
    the master, ``lost`` why a node that is not alive has ended, and ``call`` how people call a service.

    Args:
        name: of the node, if no remap gives it another.
        remaps: as roslaunch appends them to a command, such as ``__name:=flyer`` and ``odom:=pose``.
    """

    call = "rosservice call {}"

    def __init__(self, name: str, has_clock: bool = True, remaps: Sequence[str] = ()) -> None:
        find_rospy()
        import rosgraph
        import rospy
        import tf2_ros

        self.address = os.environ.setdefault("ROS_MASTER_URI", "http://localhost:11311")
        self.has_clock, self._rospy, self._lost = has_clock, rospy, threading.Event()
        self.lost = (
            f"roscore at {self.address} does not answer any more, or another node has taken the name of this one"
        )
        self.ros = make_messages(None)
        self._master = rosgraph.Master(f"/{name}")
        if not self._ask():
            raise WorkFailedError(
                f"no roscore answers at {self.address}: start roscore, or set ROS_MASTER_URI to where it runs"
            )
        rospy.init_node(name, argv=list(remaps), disable_signals=True)
        self._sets_time = has_clock and not rospy.get_param("/use_sim_time", False)
        if self._sets_time:
            rospy.set_param("/use_sim_time", True)
        threading.Thread(target=self._watch, daemon=True).start()
        self._publishers: dict[str, tuple[Any, Any]] = {}
        self._frames = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._frames)

    def __exit__(self, *_: object) -> None:
        if not self.is_alive():
            # Its threads would ask a master that is gone, and say so.
            return
        if self._sets_time:
            self._rospy.delete_param("/use_sim_time")
        # Time for what waits for subscribers.
        time.sleep(FLUSH)
        self._rospy.signal_shutdown("the flight has ended")

    def _ask(self) -> bool:
        try:
            self._master.getPid()
        except OSError:
            return False
        return True

    def _watch(self) -> None:
        while self._ask():
            self._lost.wait(PATIENCE)
        self._lost.set()

    def is_alive(self) -> bool:
        """Return whether the master still answers, and knows this node."""
        return not self._lost.is_set() and not self._rospy.is_shutdown()

    def check_clock(self) -> None:
        """Raise WorkFailedError if another node publishes the time of ROS, and has done so for longer."""
        publishers, _, _ = self._master.getSystemState()
        # In the order in which they came.
        first = next((nodes[0] for topic, nodes in publishers if topic == "/clock"), self._rospy.get_name())
        if self.has_clock and first != self._rospy.get_name():
            raise WorkFailedError(
                f"{first} publishes /clock, and two clocks would jump: give --no-clock (rosnode cleanup, if it has ended)"
            )

    def _make_type(self, kind: str) -> Any:
        """Return a type of messages whose content is bytes, with the digest by which ROS 1 compares definitions."""
        text, digest = self.ros.store.generate_msgdef(full_name(kind), ros_version=1)
        own = {"_type": kind, "_md5sum": digest, "_full_text": text, "__slots__": ()}
        return type("Raw", (self._rospy.AnyMsg,), own)

    def advertise(self, topic: str, kind: str, latched: bool) -> None:
        """Advertise a topic; ``kind`` is the type of its messages, such as ``nav_msgs/Odometry``."""
        if topic not in self._publishers:
            kind_of = self._make_type(kind)
            publisher = self._rospy.Publisher(topic, kind_of, latch=latched, queue_size=QUEUE)
            self._publishers[topic] = kind_of, publisher

    def publish(self, topic: str, message: bytes) -> None:
        """Publish an encoded message on an advertised topic."""
        kind_of, publisher = self._publishers[topic]
        raw = kind_of()
        raw._buff = message
        publisher.publish(raw)

    def receive_currents(self, world: str, take: Callable[[Current], None]) -> None:
        """Call ``take`` with the velocity (frame ``world``, m/s) of each message of :data:`~driftform_ros.currents.TOPIC`."""

        def receive(message: Any) -> None:
            twist = self.ros.store.deserialize_ros1(message._buff, full_name("geometry_msgs/TwistStamped"))
            if (current := turn_current(twist, world, self._frames, self._rospy.Time(0))) is not None:
                take(current)

        self._rospy.Subscriber(TOPIC, self._make_type("geometry_msgs/TwistStamped"), receive)

    def serve(self, name: str, answer: Callable[[], tuple[bool, str]]) -> None:
        """Offer a service of the type ``std_srvs/Trigger``."""
        from std_srvs.srv import Trigger, TriggerResponse

        self._rospy.Service(name, Trigger, lambda _: TriggerResponse(*answer()))

    def read_parameter(self, name: str) -> str | None:
        """Return a parameter as text, ``None`` if it is not set."""
        found = self._rospy.get_param(name, None)
        return None if found is None else str(found)

    def read_time(self) -> float:
        """Return the time of ROS, s; wait for it where a simulator is about to begin."""
        while not (now := float(self._rospy.get_time())) and self.is_alive():
            time.sleep(PATIENCE)
        return now
