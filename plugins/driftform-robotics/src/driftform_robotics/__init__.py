"""driftform plugins for robotics: models for Gazebo, the UUV simulator and MuJoCo, recordings for ROS, plumes of leaks."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Exporter, Fitness, Recorder


@hookimpl
def driftform_exporter() -> "list[type[Exporter[Any]]]":
    """Return exporters of models, and of worlds with the pipe and the current."""
    from driftform_robotics.models.fossen import FossenExporter
    from driftform_robotics.models.mjcf import MjcfExporter
    from driftform_robotics.models.sdf import SdfExporter
    from driftform_robotics.models.urdf import UrdfExporter
    from driftform_robotics.models.uuv import UuvExporter

    return [FossenExporter, MjcfExporter, SdfExporter, UrdfExporter, UuvExporter]


@hookimpl
def driftform_fitness() -> "type[Fitness[Any]]":
    """Return the fitness by the plume of a leak."""
    from driftform_robotics.leak import Leak

    return Leak


@hookimpl
def driftform_recorder() -> "list[type[Recorder[Any]]]":
    """Return recorders for Foxglove and RViz. Check here that rosbags is installed; import it only to write a file."""
    from driftform.util import foreign
    from driftform_robotics.recording.recorders import McapRecorder, Rosbag1Recorder, Rosbag2Recorder

    foreign.require_module("rosbags")
    return [McapRecorder, Rosbag1Recorder, Rosbag2Recorder]


@hookimpl
def driftform_scenarios() -> str:
    """Return the package of the scenario with a leak."""
    return "driftform_robotics.scenarios"
