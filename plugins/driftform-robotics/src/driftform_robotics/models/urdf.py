"""URDF: the link that ROS, Drake, MuJoCo and many other programs read. URDF cannot describe water.

Format: http://wiki.ros.org/urdf/XML.
"""

import xml.etree.ElementTree as ET
from typing import ClassVar

import numpy as np

from driftform.interfaces import Table, option
from driftform_robotics.models import xml
from driftform_robotics.models.exporter import HULL, Model, ModelExporter, piece_path
from driftform_robotics.models.gap import COMMON_STEP, Reader, measure_gap
from driftform_robotics.models.link import warn_of_folding
from driftform_robotics.models.ros2 import list_items, make_package, read_template
from driftform_robotics.models.xml import add, add_comment

ZERO = "0 0 0"


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
        dry = Reader("a program that knows no water", *4 * (np.zeros((6, 6)),), 0.0)
        gap = measure_gap(dry, model.job, model.link, COMMON_STEP)
        warnings = [gap.describe(), *warn_of_folding(model.job.agent.body)]
        files = {"agent.urdf": xml.format_document(self._make_robot(model, name, warnings))}
        files |= make_package(
            name,
            f"The agent {model.job.name} of driftform: its URDF, without water",
            [*files, HULL],
            launch=("display.launch.py", read_template("display.launch.py.in")),
            depends=("launch", "launch_ros", "robot_state_publisher", "rviz2"),
            readme=read_template("urdf-readme.md.in").format(
                agent=model.job.name, package=name, warnings=list_items(warnings)
            ),
        )
        return files, warnings

    def _make_robot(self, model: Model, package: str, warnings: list[str]) -> ET.Element:
        link = model.link
        root = ET.Element("robot", name=model.title)
        add_comment(
            root,
            "The origin is the centre of gravity; x points forward along the axis; z points up.",
            *warnings,
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
