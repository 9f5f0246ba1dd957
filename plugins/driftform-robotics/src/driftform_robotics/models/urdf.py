"""URDF: the link that ROS, Drake, MuJoCo and many other programs read. URDF cannot describe water.

Format: http://wiki.ros.org/urdf/XML.
"""

import xml.etree.ElementTree as ET
from typing import ClassVar

from driftform.options import Table, option
from driftform_robotics.models.exporter import Model, ModelExporter
from driftform_robotics.models.folder import HULL, piece_path
from driftform_robotics.models.link import warn_of_folding
from driftform_robotics.models.xml import (
    add,
    add_comment,
    format_document,
    format_number,
    format_numbers,
    format_symmetric,
)

ZERO = "0 0 0"


class UrdfOptions(Table):
    """Options of the exporter."""

    floating: bool = option(
        True,
        "start with a link 'world' and a floating joint; without them some programs fix the agent to the world",
    )


class UrdfExporter(ModelExporter[UrdfOptions]):
    """A plain URDF as a ROS package: mass, inertia, convex pieces for collisions and the hull for display; no water.

    The package holds `agent.urdf`, `package.xml` and `CMakeLists.txt`. The link's origin is the centre of gravity.
    """

    name = "urdf"
    suffix = "-urdf"
    Options: ClassVar[type[Table]] = UrdfOptions

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return ``agent.urdf``, ``package.xml`` and ``CMakeLists.txt``, and the warnings."""
        files = {"agent.urdf": format_document(self._make_robot(model)), **package_files(model)}
        return files, warn_of_folding(model.job.agent.body)

    def _make_robot(self, model: Model) -> ET.Element:
        link = model.link
        root = ET.Element("robot", name=model.title)
        add_comment(
            root,
            [
                "The origin is the centre of gravity; x points forward along the axis; z points up.",
                "URDF cannot describe water. The displaced volume is "
                f"{format_number(link.volume)} m3, about {format_numbers(link.buoyancy)} m. The added mass is",
                *(format_numbers(row) for row in link.added_mass),
            ],
        )
        # For MuJoCo, which drops the folders of meshes in a URDF; other programs ignore it.
        add(
            add(root, "mujoco"),
            "compiler",
            meshdir="meshes",
            strippath="true",
            balanceinertia="false",
            discardvisual="false",
        )
        if self.options.floating:
            add(root, "link", name="world")
            joint = add(root, "joint", name="floating", type="floating")
            add(joint, "parent", link="world")
            add(joint, "child", link="base_link")
        add_link(root, "base_link", model, f"package://{model.title}")
        return root


def add_link(root: ET.Element, name: str, model: Model, folder: str) -> None:
    """Append the agent's link; ``folder`` is where its meshes are."""
    link = model.link
    element = add(root, "link", name=name)
    inertial = add(element, "inertial")
    add(inertial, "origin", xyz=ZERO, rpy=ZERO)
    add(inertial, "mass", value=format_number(link.mass))
    add(inertial, "inertia", **format_symmetric(link.inertia, "xyz", "i"))
    visual = add(element, "visual", name="hull")
    add(visual, "origin", xyz=ZERO, rpy=ZERO)
    add(add(visual, "geometry"), "mesh", filename=f"{folder}/{HULL}")
    for index, piece in enumerate(model.pieces):
        collision = add(element, "collision", name=f"piece_{index}")
        add(collision, "origin", xyz=format_numbers(model.axis_point(piece.x)), rpy=ZERO)
        add(add(collision, "geometry"), "mesh", filename=f"{folder}/{piece_path(index)}")


def package_files(model: Model, depends: tuple[str, ...] = ()) -> dict[str, str]:
    """Return the files that make a folder a ROS package for catkin."""
    root = ET.Element("package", format="2")
    add(root, "name", model.title)
    add(root, "version", "0.1.0")
    add(root, "description", f"The agent {model.job.name} of driftform")
    add(root, "maintainer", "driftform", email="driftform@localhost")
    add(root, "license", "MIT")
    add(root, "buildtool_depend", "catkin")
    for package in depends:
        add(root, "exec_depend", package)
    build = f"""cmake_minimum_required(VERSION 3.0.2)
project({model.title})
find_package(catkin REQUIRED)
catkin_package()
install(DIRECTORY . DESTINATION ${{CATKIN_PACKAGE_SHARE_DESTINATION}})
"""
    return {"package.xml": format_document(root), "CMakeLists.txt": build}
