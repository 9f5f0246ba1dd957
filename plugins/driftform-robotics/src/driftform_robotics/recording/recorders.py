"""Flights for Foxglove and RViz, as one MCAP file or as a bag of ROS 2 or ROS 1."""

import json
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

from driftform.interfaces import ExportJob, Recorder
from driftform.types import Trajectory, WrittenFile
from driftform.util import files
from driftform_robotics.options import FlightOptions, Ros2Options


class McapRecorder(Recorder[Ros2Options]):
    """A flight as one MCAP file with messages of ROS 2, for Foxglove and other programs that read MCAP.

    It holds transforms, odometry, the net force and torque, markers of the pipe, the targets and the agent, and the
    readings of sensors on the agent. Writing it does not need ROS.
    """

    name = "mcap"
    suffix = ".mcap"
    Options = Ros2Options

    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        """Write the file."""

        def write(part: Path) -> dict[str, object]:
            # A bag with this storage is a folder with one MCAP file, which contains the name of the folder.
            with TemporaryDirectory(dir=part.parent, ignore_cleanup_errors=True) as scratch:
                bag = Path(scratch) / path.stem
                facts = _write_bag(bag, job, trajectory, self.options, "mcap")
                (bag / f"{bag.name}.mcap").replace(part)
            return facts

        return _write_file(self.name, path, write)


class Rosbag2Recorder(Recorder[Ros2Options]):
    """A flight as a bag of ROS 2, for ``ros2 bag play``, RViz and Foxglove: a folder with its metadata.

    It holds the same messages as ``mcap``. Writing it does not need ROS.
    """

    name = "rosbag2"
    suffix = "-rosbag2"
    Options = Ros2Options

    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        """Write the folder."""
        with files.write_folder(path) as part:
            # The writer makes a new folder, and names the file with the messages after it.
            bag = part / path.name
            facts = _write_bag(bag, job, trajectory, self.options, "sqlite3")
            for file in bag.iterdir():
                file.replace(part / file.name)
            bag.rmdir()
            names = sorted(file.name for file in part.iterdir())
        return tuple(
            WrittenFile(self.name, str(path / name), facts if name == "metadata.yaml" else {}) for name in names
        )


class Rosbag1Recorder(Recorder[FlightOptions]):
    """A flight as a bag of ROS 1, for ``rosbag play`` and RViz: one file.

    It holds the same messages as ``rosbag2``, by the definitions of Noetic. Writing it does not need ROS.
    """

    name = "rosbag1"
    suffix = ".bag"
    Options = FlightOptions

    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        """Write the file."""
        return _write_file(self.name, path, lambda part: _write_bag(part, job, trajectory, self.options, None))


def _write_file(name: str, path: Path, write: Callable[[Path], dict[str, object]]) -> tuple[WrittenFile, ...]:
    """Write a recording of one file by a function that returns its facts; a failure leaves no partial file."""
    facts: dict[str, object] = {}
    files.write_whole(path, lambda part: facts.update(write(part)))
    return (WrittenFile(name, str(path), facts),)


def _write_bag(
    path: Path,
    job: ExportJob,
    trajectory: Trajectory,
    options: FlightOptions,
    storage: Literal["sqlite3", "mcap"] | None,
) -> dict[str, object]:
    """Write a bag of ROS 2 with this storage, or of ROS 1 without one; return its facts."""
    from driftform_robotics.recording.bag import write_bag
    from driftform_robotics.recording.messages import make_messages
    from driftform_robotics.recording.topics import FlightTopics

    ros = make_messages(options.release if isinstance(options, Ros2Options) else None)
    notes = {"agent": job.name, "end": str(trajectory.end), "document": json.dumps(job.document)}
    counts = write_bag(path, FlightTopics(job, trajectory, options).list_topics(), ros, storage, notes)
    return {"messages": sum(counts.values()), "duration": float(trajectory.t[-1]), "topics": counts}
