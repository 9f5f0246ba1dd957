"""Topics -> a bag of ROS 2, which is a folder with the messages and ``metadata.yaml``, or of ROS 1, which is a file."""

from collections.abc import Mapping, Sequence
from heapq import merge
from itertools import repeat
from pathlib import Path
from typing import Any, Literal

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from driftform_robotics.recording.messages import Messages, full_name
from driftform_robotics.recording.topics import Topic

VERSION: Literal[8] = 8
"""Version of the metadata that Humble and all later releases read."""


def write_bag(
    path: Path,
    topics: Sequence[Topic],
    ros: Messages,
    storage: Literal["sqlite3", "mcap"] | None,
    notes: Mapping[str, str],
) -> dict[str, int]:
    """Write a bag into a folder or a file that does not exist yet; return the number of messages of each topic.

    Messages are sorted by time; messages with the same time are in the order of ``topics``. Without a ``storage`` the bag
    is one of ROS 1, which has no place for ``notes``.
    """
    writer: Writer | Writer1
    if storage is None:
        writer = Writer1(path)
    else:
        writer = Writer(path, version=VERSION, storage_plugin=StoragePlugin[storage.upper()])
        if storage == "mcap":
            writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        for key, text in notes.items():
            writer.set_custom_data(key, text)
    counts = dict.fromkeys((topic.name for topic in topics), 0)
    with writer:
        streams = []
        for topic in topics:
            kind, latched = full_name(topic.kind), topic.latched
            more: dict[str, Any] = (
                {"latching": int(latched)} if storage is None else {"offered_qos_profiles": [_make_qos(latched)]}
            )
            connection = writer.add_connection(topic.name, kind, typestore=ros.store, **more)
            streams.append(zip(repeat(topic), repeat(connection), topic.messages()))
        for topic, connection, (stamp, values) in merge(*streams, key=lambda item: item[2][0]):
            writer.write(connection, stamp, ros.encode(topic.kind, values))
            counts[topic.name] += 1
    return counts


def _make_qos(latched: bool) -> Qos:
    """Return a reliable quality of service; a latched topic keeps its last message for later subscribers."""
    forever = QosTime(2_147_483_647, 4_294_967_295)
    return Qos(
        QosHistory.KEEP_LAST,
        1 if latched else 10,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        forever,
        forever,
        QosLiveliness.AUTOMATIC,
        forever,
        avoid_ros_namespace_conventions=False,
    )
