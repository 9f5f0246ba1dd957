"""A ROS 2 package around the files of an agent: package.xml, CMakeLists.txt, a launch file, a bridge, a README.

Formats: REP 149 (package.xml, format 3), REP 144 (names of packages), ``ament_cmake``, and the YAML files of
``ros_gz_bridge``. The files follow the linters of ``ament_lint``: a copyright notice, single quotes, at most 99 columns.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from driftform_robotics.models.xml import add, add_maintainer, add_texts, format_document

_SCHEMA = (
    '<?xml-model href="http://download.ros.org/schema/package_format3.xsd" '
    'schematypens="http://www.w3.org/2001/XMLSchema"?>\n'
)

_NOTICE = "Copyright 2026 the driftform authors"


@cache
def read_template(name: str) -> str:
    """Return a text of the package's files, with the names that are to be replaced in it."""
    return files("driftform_robotics.models").joinpath("templates", name).read_text(encoding="utf-8")


def list_items(texts: Iterable[str]) -> str:
    """Return texts as a list in Markdown."""
    return "\n".join(f"- {text}" for text in texts) or "Nothing."


@dataclass(frozen=True)
class Bridge:
    """One topic of a bridge between Gazebo and ROS: names, types of messages, and ``direction``."""

    ros: str
    gazebo: str
    ros_type: str
    gazebo_type: str
    direction: str


def make_package(
    name: str,
    description: str,
    others: Iterable[str],
    *,
    launch: tuple[str, str],
    depends: Sequence[str],
    readme: str,
    bridges: Sequence[Bridge] = (),
) -> dict[str, str]:
    """Return the files that make a folder a ROS 2 package.

    Parameters
    ----------
    name
        of the package, in lower-case letters, digits and underscores.
    description
        one sentence.
    others
        paths of the other files in the folder: shell scripts are installed as programs, the others to be shared.
    launch
        name and text of the launch file, which is a Python file without its copyright notice.
    depends
        packages that the launch file starts.
    readme
        text of ``README.md``.
    bridges
        topics of ``config/bridge.yaml``.
    """
    config = {"config/bridge.yaml": _format_bridges(bridges)} if bridges else {}
    # The linters expect the notice at the top of a Python file.
    licence = f"{_NOTICE}\n\n{read_template('mit-licence.txt')}"
    notice = "".join(f"# {line}".rstrip() + "\n" for line in licence.splitlines())
    made = {f"launch/{launch[0]}": f"{notice}\n{launch[1]}", **config}
    return {
        "package.xml": _format_manifest(name, description, depends),
        "CMakeLists.txt": _format_build(name, [*others, *made]),
        **made,
        "README.md": readme,
        "LICENSE": f"MIT License\n\n{licence}",
    }


def _format_manifest(name: str, description: str, depends: Sequence[str]) -> str:
    root = ET.Element("package", format="3")
    add_texts(root, name=name, version="0.1.0", description=description)
    add_maintainer(root)
    add(root, "license", "MIT", file="LICENSE")
    add(root, "buildtool_depend", "ament_cmake")
    for package in depends:
        add(root, "exec_depend", package)
    add(add(root, "export"), "build_type", "ament_cmake")
    declaration, _, rest = format_document(root).partition("\n")
    return f"{declaration}\n{_SCHEMA}{rest}"


def _format_build(name: str, files: Sequence[str]) -> str:
    programs = sorted(path for path in files if path.endswith(".sh"))
    single = sorted(path for path in files if "/" not in path and path not in programs)
    folders = sorted({path.partition("/")[0] for path in files if "/" in path})
    text = f"""\
cmake_minimum_required(VERSION 3.10)
project({name})

find_package(ament_cmake REQUIRED)

install(
  FILES {" ".join(single)}
  DESTINATION share/${{PROJECT_NAME}})

install(
  DIRECTORY {" ".join(folders)}
  DESTINATION share/${{PROJECT_NAME}})

"""
    if programs:
        text += f"""\
install(
  PROGRAMS {" ".join(programs)}
  DESTINATION lib/${{PROJECT_NAME}})

"""
    return text + "ament_package()\n"


def _format_bridges(bridges: Sequence[Bridge]) -> str:
    return "---\n" + "".join(
        f'- ros_topic_name: "{bridge.ros}"\n'
        f'  gz_topic_name: "{bridge.gazebo}"\n'
        f'  ros_type_name: "{bridge.ros_type}"\n'
        f'  gz_type_name: "{bridge.gazebo_type}"\n'
        f"  direction: {bridge.direction}\n"
        for bridge in bridges
    )
