"""``driftform ros``."""

import signal
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from driftform.cli import options

if TYPE_CHECKING:
    from driftform import Design


def ros(
    agent: options.Agent,
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
        bool, typer.Option(help="Publish /clock and set /use_sim_time; --no-clock if a simulator publishes it.")
    ] = True,
    scenario: options.ScenarioOption = None,
    simulator: options.Simulator = None,
    hydrodynamics: options.Hydrodynamics = None,
    settings: options.Settings = None,
) -> None:
    """Fly an agent live on a running roscore: clock, transforms, odometry, hull and sensors, as 'export-flight' writes them.

    The water has the velocity of the topic 'hydrodynamics/current_velocity' as soon as one arrives. The services 'release'
    and 'evaluate' take an agent or a genome from the parameter 'agent', all in the namespace of the agent.
    """
    from driftform import open_agent
    from driftform_robotics.options import FlightOptions
    from driftform_ros.node import LiveNode
    from driftform_ros.rospy_bus import RospyBus

    use = {"simulator": simulator, "hydrodynamics": hydrodynamics}

    def open_named(text: str) -> "Design":
        return open_agent(text, *(settings or ()), scenario=scenario, use=use)

    design = open_named(agent)

    def open_other(text: str) -> "Design":
        found = open_named(text)
        if found.stored.result or Path(text).is_file():
            return found
        # A genome belongs to the study of the agent that flies, whose settings it has.
        return type(found).build(replace(found.stored, environment=design.study.environment()), text)

    given = design.study.make_recorder("rosbag1").options
    assert isinstance(given, FlightOptions)
    design.fly()  # Fails before a node exists, if this agent cannot fly.
    # As roslaunch ends its nodes.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with RospyBus(f"driftform_{given.namespace}", clock) as bus:
        LiveNode(bus, open_other, given, 1 / rate_hz, rate).run(design, once)
