"""A ROS 2 package around the files of an agent: package.xml, CMakeLists.txt, a launch file, a README.

Formats: REP 149 (package.xml, format 3), REP 144 (names of packages), and ``ament_cmake``.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from driftform_robotics.models.text import render


def make_package(
    package: str,
    description: str,
    others: Iterable[str],
    launch: str,
    depends: Sequence[str],
    configuration: Mapping[str, str] | None = None,
    **values: Any,
) -> dict[str, str]:
    """Return the files that make a folder a ROS 2 package.

    Args:
        package: name, in lower-case letters, digits and underscores.
        others: paths of the other files in the folder: shell scripts are installed as programs, the others to be
            shared.
        launch: path of the launch file's template, without its copyright notice; a README is in the same folder.
        depends: packages that the launch file starts.
        configuration: texts of further files by their paths.
        values: of the two templates.
    """
    others = list(others)
    values = {"package": package, "others": others, **values}
    folder, _, name = launch.removesuffix(".in").partition("/")
    made = {f"launch/{name}": render(launch, **values), **(configuration or {})}
    paths = [*others, *made]
    programs = sorted(path for path in paths if path.endswith(".sh"))
    single = sorted(path for path in paths if "/" not in path and path not in programs)
    folders = sorted({path.partition("/")[0] for path in paths if "/" in path})
    build = render("ros2/CMakeLists.txt", name=package, programs=programs, single=single, folders=folders)
    return {
        "package.xml": render("ros2/package.xml.in", name=package, description=description, depends=depends),
        "CMakeLists.txt": build,
        **made,
        "README.md": render(f"{folder}/README.md", **values),
        "LICENSE": f"MIT License\n\n{render('ros2/notice.txt')}",
    }
