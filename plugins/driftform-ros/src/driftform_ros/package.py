"""A package of ROS 1 that launches a live flight; it needs no build where ROS_PACKAGE_PATH leads to it."""

import sys
from collections.abc import Sequence
from pathlib import Path
from shlex import join, quote

from driftform.util import files
from driftform_robotics.models.text import make_identifier, render
from driftform_robotics.options import FlightOptions

_FILES = {
    "package.xml": "package.xml",
    "CMakeLists.txt": "CMakeLists.txt",
    "driftform": "driftform.sh",
    "launch/live.launch": "live.launch",
    "rviz/live.rviz": "live.yaml",
}


def write_package(folder: Path, agent: str, options: Sequence[str], flight: FlightOptions) -> str:
    """Write the package into a folder that it is named after, and return its name.

    ``agent`` is a genome, a file or an agent of a run, and ``options`` those of the command.
    """
    name = make_identifier(folder.name)
    # roslaunch starts its nodes in a folder of its own.
    agent, *given = (_find_place(word) for word in (agent, *options))
    values = {"name": name, "agent": quote(agent), "options": join(given), "python": quote(sys.executable)}
    files.check_new_directory(folder)
    with files.write_folder(folder) as part:
        for path, template in _FILES.items():
            (part / path).parent.mkdir(exist_ok=True)
            text = render(f"live/{template}", **values, namespace=flight.namespace, world=flight.world)
            (part / path).write_text(text, encoding="utf-8")
        (part / "driftform").chmod(0o755)
    return name


def _find_place(word: str) -> str:
    """Return a word with the whole path of the file or the run that it names, if it does."""
    run, colon, target = word.partition(":")
    return f"{Path(run).resolve()}{colon}{target}" if run and Path(run).exists() else word
