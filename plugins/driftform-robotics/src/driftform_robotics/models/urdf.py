"""URDF: the link that ROS, Drake, MuJoCo and many other programs read. URDF cannot describe water.

Format: http://wiki.ros.org/urdf/XML.
"""

import xml.etree.ElementTree as ET
from typing import ClassVar

from driftform.interfaces import Table, option
from driftform_robotics.models import xml
from driftform_robotics.models.exporter import HULL, Model, ModelExporter, piece_path
from driftform_robotics.models.link import warn_of_folding
from driftform_robotics.models.ros2 import make_package
from driftform_robotics.models.xml import add, add_comment

ZERO = "0 0 0"

_LAUNCH = """\
\"\"\"Show the agent in RViz: add a RobotModel, and choose the fixed frame 'world' or 'base_link'.\"\"\"

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    \"\"\"Start robot_state_publisher, and RViz unless rviz:=false.\"\"\"
    share = Path(__file__).resolve().parents[1]
    description = (share / 'agent.urdf').read_text(encoding='utf-8')
    return LaunchDescription([
        DeclareLaunchArgument('rviz', default_value='true', description='start RViz'),
        DeclareLaunchArgument('frame_prefix', default_value='', description='prefix of frames'),
        Node(
            package='robot_state_publisher',
            executable='robot_state_publisher',
            parameters=[{
                'robot_description': description,
                'frame_prefix': LaunchConfiguration('frame_prefix'),
            }],
        ),
        Node(
            package='rviz2',
            executable='rviz2',
            condition=IfCondition(LaunchConfiguration('rviz')),
        ),
    ])
"""

_README = """\
# {package}

The agent {agent} of driftform as URDF: mass, inertia and meshes, in a ROS 2 package. URDF cannot describe water; the format
`sdf` of driftform writes a package with water, pipe and current for Gazebo.

## Build and show

Copy this folder into the `src` folder of a workspace, then

    colcon build --packages-select {package}
    source install/setup.bash
    ros2 launch {package} display.launch.py

In RViz add a *RobotModel* with the description topic `/robot_description`.

## Frames

The origin of `base_link` is the centre of gravity; x points forward along the axis, z up; lengths are in m. The link `world`
and a floating joint come first, without which MuJoCo fixes the agent to the world. `robot_state_publisher` takes a
floating joint as fixed: to show the poses of a flight that another node publishes on `/tf`, export with the option
`floating = false`, and set `frame_prefix` to that of its frames.

Programs without ROS find the meshes if they know this package: in Drake `parser.package_map().AddPackageXml("package.xml")`.
"""


class UrdfOptions(Table):
    """Options of the exporter."""

    floating: bool = option(
        True,
        "start with a link 'world' and a floating joint; without them some programs fix the agent to the world",
    )


class UrdfExporter(ModelExporter[UrdfOptions]):
    """A plain URDF as a ROS 2 package: mass, inertia, convex pieces for collisions and the hull for display; no water.

    The package, whose name ends in `_description`, holds `agent.urdf`, meshes, and a launch file that shows the agent in
    RViz. The link's origin is the centre of gravity.
    """

    name = "urdf"
    suffix = "-urdf"
    Options: ClassVar[type[Table]] = UrdfOptions

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return ``agent.urdf`` and the files of a ROS 2 package, and the warnings."""
        name = f"{model.title}_description"
        files = {"agent.urdf": xml.format_document(self._make_robot(model, name))}
        files |= make_package(
            name,
            f"The agent {model.job.name} of driftform: its URDF, without water",
            [*files, HULL],
            launch=("display.launch.py", _LAUNCH),
            depends=("launch", "launch_ros", "robot_state_publisher", "rviz2"),
            readme=_README.format(agent=model.job.name, package=name),
        )
        return files, list(warn_of_folding(model.job.agent.body))

    def _make_robot(self, model: Model, package: str) -> ET.Element:
        link = model.link
        root = ET.Element("robot", name=model.title)
        add_comment(
            root,
            "The origin is the centre of gravity; x points forward along the axis; z points up.",
            "URDF cannot describe water. The displaced volume is "
            f"{xml.format_number(link.volume)} m3, about {xml.format_numbers(link.buoyancy)} m. The added mass is",
            *(xml.format_numbers(row) for row in link.added_mass),
        )
        # For MuJoCo, which drops the folders of meshes in a URDF; other programs ignore it.
        kept = {"balanceinertia": "false", "discardvisual": "false"}
        add(add(root, "mujoco"), "compiler", meshdir="meshes", strippath="true", **kept)
        if self.options.floating:
            add(root, "link", name="world")
            joint = add(root, "joint", name="floating", type="floating")
            add(joint, "parent", link="world")
            add(joint, "child", link="base_link")
        add_link(root, "base_link", model, f"package://{package}")
        return root


def add_link(root: ET.Element, name: str, model: Model, folder: str) -> None:
    """Append the agent's link; ``folder`` is where its meshes are."""
    link = model.link
    element = add(root, "link", name=name)
    inertial = add(element, "inertial")
    add(inertial, "origin", xyz=ZERO, rpy=ZERO)
    add(inertial, "mass", value=link.mass)
    add(inertial, "inertia", **xml.format_symmetric(link.inertia, "xyz", "i"))
    visual = add(element, "visual", name="hull")
    add(visual, "origin", xyz=ZERO, rpy=ZERO)
    add(add(visual, "geometry"), "mesh", filename=f"{folder}/{HULL}")
    for index, piece in enumerate(model.pieces):
        collision = add(element, "collision", name=f"piece_{index}")
        add(collision, "origin", xyz=model.axis_point(piece.x), rpy=ZERO)
        add(add(collision, "geometry"), "mesh", filename=f"{folder}/{piece_path(index)}")
