"""Agents for the simulators of roboticists: Gazebo, the UUV simulator and MuJoCo, as driftform plugins."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Exporter, Fitness, Recorder


@hookimpl
def driftform_exporter() -> "list[type[Exporter[Any]]]":
    """Models, and worlds with the pipe and the current around them."""
    from driftform_robotics.models.mjcf import MjcfExporter
    from driftform_robotics.models.sdf import SdfExporter
    from driftform_robotics.models.urdf import UrdfExporter
    from driftform_robotics.models.uuv import UuvExporter

    return [MjcfExporter, SdfExporter, UrdfExporter, UuvExporter]


@hookimpl
def driftform_fitness() -> "type[Fitness[Any]]":
    """What a chemical sensor sees of the plume of a leak."""
    from driftform_robotics.leak import Leak

    return Leak


@hookimpl
def driftform_recorder() -> "list[type[Recorder[Any]]]":
    """Flights for Foxglove and RViz; what writes them is looked for here and imported where one is written."""
    from driftform.registry import require_module
    from driftform_robotics.recording.recorders import McapRecorder, Rosbag2Recorder

    require_module("rosbags")
    return [McapRecorder, Rosbag2Recorder]
