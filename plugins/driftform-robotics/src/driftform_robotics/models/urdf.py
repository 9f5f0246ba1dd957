"""URDF: the link that ROS, Drake, MuJoCo and many others read. It knows nothing of water.

Format: http://wiki.ros.org/urdf/XML.
"""

import xml.etree.ElementTree as ET
from itertools import combinations_with_replacement
from pathlib import Path
from typing import ClassVar

import numpy as np

from driftform.interfaces import Exporter, ExportJob
from driftform.options import Table, option
from driftform.types import FloatArray, WrittenFile
from driftform_robotics.models.folder import HULL, cut_hull, hull_files, model_facts, piece_path, save_folder
from driftform_robotics.models.link import Link, make_link, warn_of_folding
from driftform_robotics.models.meshes import Piece
from driftform_robotics.models.xml import (
    add,
    add_comment,
    format_document,
    format_number,
    format_numbers,
    make_identifier,
)

ZERO = "0 0 0"


class UrdfOptions(Table):
    """Options of the exporter."""

    floating: bool = option(
        True,
        "begin with a link 'world' and a floating joint, without which some programs weld the agent to the world",
    )


class UrdfExporter(Exporter[UrdfOptions]):
    """A plain URDF as a ROS package: mass, inertia, convex pieces to collide and the hull to look at; no water.

    The link's origin is the centre of gravity.
    """

    name = "urdf"
    suffix = "-urdf"
    Options: ClassVar[type[Table]] = UrdfOptions

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write ``agent.urdf``, ``package.xml`` and ``CMakeLists.txt``, and meshes.

        Facts: as those of ``sdf``.

        Raises
        ------
        WorkFailedError
            where the body has no solid, or the files cannot be written.
        """
        body, title = job.agent.body, make_identifier(job.name)
        pieces, link = cut_hull(body), make_link(job)
        files = {
            "agent.urdf": format_document(self._make_robot(title, job, link, pieces)),
            **package_files(title, job.name),
            **hull_files(body, job.agent.mass.cog, pieces),
        }
        return save_folder(self.name, path, files, model_facts(link, warn_of_folding(body)))

    def _make_robot(self, title: str, job: ExportJob, link: Link, pieces: list[Piece]) -> ET.Element:
        root = ET.Element("robot", name=title)
        add_comment(
            root,
            [
                "The origin is the centre of gravity; x is the axis, forward; z is up. URDF knows no water:",
                f"it displaces {format_number(link.volume)} m3 about {format_numbers(link.buoyancy)} m, and its added mass is",
                *(format_numbers(row) for row in link.added_mass),
            ],
        )
        # For MuJoCo, which drops the folders of meshes in a URDF; other programs pass over it.
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
        add_link(root, "base_link", link, pieces, job.agent.mass.cog, f"package://{title}")
        return root


def add_link(
    root: ET.Element, name: str, link: Link, pieces: list[Piece], cog: FloatArray, folder: str
) -> None:
    """Append the agent's link; ``folder`` is where its meshes are."""
    element = add(root, "link", name=name)
    inertial = add(element, "inertial")
    add(inertial, "origin", xyz=ZERO, rpy=ZERO)
    add(inertial, "mass", value=format_number(link.mass))
    pairs = combinations_with_replacement(range(3), 2)
    add(
        inertial, "inertia", **{f"i{'xyz'[i]}{'xyz'[j]}": format_number(link.inertia[i, j]) for i, j in pairs}
    )
    visual = add(element, "visual", name="hull")
    add(visual, "origin", xyz=ZERO, rpy=ZERO)
    add(add(visual, "geometry"), "mesh", filename=f"{folder}/{HULL}")
    for index, piece in enumerate(pieces):
        collision = add(element, "collision", name=f"piece_{index}")
        add(collision, "origin", xyz=format_numbers(np.array([piece.x, 0.0, 0.0]) - cog), rpy=ZERO)
        add(add(collision, "geometry"), "mesh", filename=f"{folder}/{piece_path(index)}")


def package_files(title: str, name: str, depends: tuple[str, ...] = ()) -> dict[str, str]:
    """Return what makes a folder a ROS package that catkin finds."""
    root = ET.Element("package", format="2")
    add(root, "name", title)
    add(root, "version", "0.1.0")
    add(root, "description", f"The agent {name} of driftform")
    add(root, "maintainer", "driftform", email="driftform@localhost")
    add(root, "license", "MIT")
    add(root, "buildtool_depend", "catkin")
    for package in depends:
        add(root, "exec_depend", package)
    build = f"""cmake_minimum_required(VERSION 3.0.2)
project({title})
find_package(catkin REQUIRED)
catkin_package()
install(DIRECTORY . DESTINATION ${{CATKIN_PACKAGE_SHARE_DESTINATION}})
"""
    return {"package.xml": format_document(root), "CMakeLists.txt": build}
