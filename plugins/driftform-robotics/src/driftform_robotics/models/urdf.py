"""URDF: the link that ROS, Drake, MuJoCo and many other programs read. URDF cannot describe water.

Format: http://wiki.ros.org/urdf/XML.
"""

from typing import Any, ClassVar

from driftform.interfaces import Table, option
from driftform_robotics.models.exporter import HULL, Model, ModelExporter
from driftform_robotics.models.ros2 import make_package
from driftform_robotics.models.text import list_lines, render


class UrdfOptions(Table):
    """Options of the exporter."""

    floating: bool = option(
        True, "start with a link 'world' and a floating joint; without them some programs fix the agent to the world"
    )


class UrdfExporter(ModelExporter[UrdfOptions]):
    """A plain URDF as a ROS 2 package: mass, inertia, convex pieces for collisions and the hull for display; no water.

    The package, whose name ends in `_description`, holds `agent.urdf`, meshes, and a launch file that shows the agent in
    RViz. The link's origin is the centre of gravity.
    """

    name = "urdf"
    suffix = "-urdf"
    Options: ClassVar[type[Table]] = UrdfOptions
    block = "urdf/block.xml"

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return ``agent.urdf`` and the files of a ROS 2 package, and the warnings."""
        package = f"{model.title}_description"
        warnings = list_lines("urdf/warnings.txt", model=model)
        values: dict[str, Any] = {"model": model, "warnings": warnings}
        floating = self.options.floating
        files = {"agent.urdf": render("urdf/agent.urdf", **values, package=package, floating=floating)}
        files |= make_package(
            package,
            f"The agent {model.job.name} of driftform: its URDF, without water",
            [*files, HULL],
            "urdf/display.launch.py.in",
            ("launch", "launch_ros", "robot_state_publisher", "rviz2"),
            **values,
        )
        return files, warnings
