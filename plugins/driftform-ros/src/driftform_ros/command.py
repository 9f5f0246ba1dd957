"""``driftform ros``."""

import os
import signal
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace as Given
from typing import TYPE_CHECKING, get_args

from driftform.cli import options

if TYPE_CHECKING:
    from driftform import Design


@options.declare(
    Path(__file__).with_name("ros.toml"),
    *("agent", "remaps", "rate", "rate_hz", "once", "clock", "max_current"),
    *("scenario", "simulator", "hydrodynamics", "settings"),
)
def ros(given: Given) -> None:
    """Fly an agent live on a running ROS: clock, transforms, odometry, hull and sensors, as 'export-flight' writes them.

    The water has the velocity of the topic 'hydrodynamics/current_velocity' as soon as one arrives. The services 'release'
    and 'evaluate' take an agent or a genome from the parameter 'agent', all in the namespace of the agent. It is a node of
    ROS 2 where ROS_VERSION is 2.
    """
    from driftform import open_agent
    from driftform.errors import InputError
    from driftform_robotics.options import FlightOptions, Release, Ros2Options
    from driftform_ros.node import LiveNode
    from driftform_ros.rclpy_bus import RclpyBus
    from driftform_ros.rospy_bus import RospyBus

    use = {"simulator": given.simulator, "hydrodynamics": given.hydrodynamics}
    words = [word for word in given.remaps or () if word not in ("--ros-args", "-r", "--remap")]
    if wrong := next((word for word in words if ":=" not in word), None):
        raise InputError(f"'{wrong}' is neither an option nor a remap, NAME:=VALUE; see 'driftform ros --help'")

    def open_named(text: str) -> "Design":
        return open_agent(text, *(given.settings or ()), scenario=given.scenario, use=use)

    design = open_named(given.agent)

    def open_other(text: str) -> "Design":
        found = open_named(text)
        if found.stored.result or Path(text).is_file():
            return found
        # A genome belongs to the study of the agent that flies, whose settings it has.
        return type(found).build(replace(found.stored, environment=design.study.environment()), text)

    is_ros2, release = os.environ.get("ROS_VERSION") == "2", os.environ.get("ROS_DISTRO")
    flight = design.study.make_recorder("rosbag2" if is_ros2 else "rosbag1").options
    assert isinstance(flight, FlightOptions)
    if isinstance(flight, Ros2Options) and release in get_args(Release):
        flight = flight.model_copy(update={"release": release})
    design.fly()  # Fails before a node exists, if this agent cannot fly.
    # As roslaunch ends its nodes.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    node = f"driftform_{flight.namespace}"
    if isinstance(flight, Ros2Options):
        bus: RclpyBus | RospyBus = RclpyBus(node, given.clock, words, flight.release)
    else:
        bus = RospyBus(node, given.clock, words)
    with bus:
        LiveNode(bus, open_other, flight, 1 / given.rate_hz, given.rate, given.max_current).run(design, given.once)
