"""``driftform ros``."""

import os
import signal
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, get_args

import typer

from driftform.cli import options

if TYPE_CHECKING:
    from driftform import Design


def ros(
    agent: options.Agent,
    remaps: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAME:=VALUE", help="Remaps, as roslaunch appends them, or after --ros-args."),
    ] = None,
    rate: Annotated[
        float, typer.Option(metavar="N", min=0, max=1000, help="Seconds of flight per second; 0 for no limit.")
    ] = 1.0,
    rate_hz: Annotated[
        float, typer.Option(metavar="HZ", min=0.1, max=1000, help="Messages per topic and second of flight.")
    ] = 20.0,
    once: Annotated[
        bool, typer.Option("--once", help="End after the flight instead of waiting for a release.")
    ] = False,
    clock: Annotated[
        bool, typer.Option(help="Publish /clock and set /use_sim_time; --no-clock if another node publishes it.")
    ] = True,
    max_current: Annotated[
        float, typer.Option(metavar="M/S", min=0, max=100, help="Fastest current that is taken from the topic, m/s.")
    ] = 20.0,
    scenario: options.ScenarioOption = None,
    simulator: options.Simulator = None,
    hydrodynamics: options.Hydrodynamics = None,
    settings: options.Settings = None,
) -> None:
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

    use = {"simulator": simulator, "hydrodynamics": hydrodynamics}
    words = [word for word in remaps or () if word not in ("--ros-args", "-r", "--remap")]
    if wrong := next((word for word in words if ":=" not in word), None):
        raise InputError(f"'{wrong}' is neither an option nor a remap, NAME:=VALUE; see 'driftform ros --help'")

    def open_named(text: str) -> "Design":
        return open_agent(text, *(settings or ()), scenario=scenario, use=use)

    design = open_named(agent)

    def open_other(text: str) -> "Design":
        found = open_named(text)
        if found.stored.result or Path(text).is_file():
            return found
        # A genome belongs to the study of the agent that flies, whose settings it has.
        return type(found).build(replace(found.stored, environment=design.study.environment()), text)

    is_ros2, release = os.environ.get("ROS_VERSION") == "2", os.environ.get("ROS_DISTRO")
    given = design.study.make_recorder("rosbag2" if is_ros2 else "rosbag1").options
    assert isinstance(given, FlightOptions)
    if isinstance(given, Ros2Options) and release in get_args(Release):
        given = given.model_copy(update={"release": release})
    design.fly()  # Fails before a node exists, if this agent cannot fly.
    # As roslaunch ends its nodes.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    node = f"driftform_{given.namespace}"
    if isinstance(given, Ros2Options):
        bus: RclpyBus | RospyBus = RclpyBus(node, clock, words, given.release)
    else:
        bus = RospyBus(node, clock, words)
    with bus:
        LiveNode(bus, open_other, given, 1 / rate_hz, rate, max_current).run(design, once)
