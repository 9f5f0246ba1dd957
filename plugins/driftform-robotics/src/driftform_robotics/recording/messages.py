"""Messages of one release of ROS, made without ROS."""

from functools import cache
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from driftform.types import FloatArray
from driftform_robotics.options import Release

SECOND = 1_000_000_000
"""Nanoseconds in a second."""


class Messages:
    """Makes messages of a release and encodes them; fields without a value are zero or empty.

    Without a ``release`` of ROS 2 they are those of Noetic, the last of ROS 1.
    """

    def __init__(self, release: Release | None) -> None:
        self.store = get_typestore(Stores[f"ROS2_{release.upper()}"] if release else Stores.ROS1_NOETIC)
        if "tf2_msgs/msg/TFMessage" not in self.store.types:
            # It is not in rosbags' definitions of Noetic, where it belongs to another repository.
            self.store.register(
                get_types_from_msg("geometry_msgs/TransformStamped[] transforms\n", "tf2_msgs/msg/TFMessage")
            )
        self._encode = self.store.serialize_cdr if release else self.store.serialize_ros1
        self._zeros: dict[str, dict[str, Any]] = {}

    def make(self, kind: str, **fields: Any) -> Any:
        """Return a message, such as ``make("geometry_msgs/Vector3", x=1.0)``; fields that the type lacks are left out."""
        name = full_name(kind)
        if name not in self._zeros:
            self._zeros[name] = {key: self._make_zero(node) for key, node in self.store.fielddefs[name][1]}
        zeros = self._zeros[name]
        return self.store.types[name](**{key: fields.get(key, zero) for key, zero in zeros.items()})

    def encode(self, kind: str, message: Any) -> bytes:
        """Return a message in CDR, or as ROS 1 serializes it."""
        return bytes(self._encode(message, full_name(kind)))

    def make_header(self, stamp: int, frame: str) -> Any:
        """Return a header; ``stamp`` is in ns."""
        return self.make("std_msgs/Header", stamp=self.make_time(stamp), frame_id=frame)

    def make_stamped(self, kind: str, stamp: int, frame: str, **fields: Any) -> Any:
        """Return a message with a header; ``stamp`` is in ns."""
        return self.make(kind, header=self.make_header(stamp, frame), **fields)

    def make_twist(self, velocity: FloatArray) -> Any:
        """Return a twist, from a linear and an angular velocity, (6,)."""
        linear, angular = self.make_vector(velocity[:3]), self.make_vector(velocity[3:])
        return self.make("geometry_msgs/Twist", linear=linear, angular=angular)

    def make_time(self, stamp: int) -> Any:
        """Return a time; ``stamp`` is in ns."""
        return self.make("builtin_interfaces/Time", sec=stamp // SECOND, nanosec=stamp % SECOND)

    def make_vector(self, values: FloatArray, kind: str = "geometry_msgs/Vector3") -> Any:
        """Return a vector or a point."""
        x, y, z = map(float, values)
        return self.make(kind, x=x, y=y, z=z)

    def make_quaternion(self, values: FloatArray) -> Any:
        """Return a quaternion of driftform (w, x, y, z) in the order of ROS: x, y, z, w."""
        w, x, y, z = map(float, values)
        return self.make("geometry_msgs/Quaternion", x=x, y=y, z=z, w=w)

    def make_pose(self, position: FloatArray, quaternion: FloatArray) -> Any:
        """Return a position with an attitude."""
        point = self.make_vector(position, "geometry_msgs/Point")
        return self.make("geometry_msgs/Pose", position=point, orientation=self.make_quaternion(quaternion))

    def _make_zero(self, node: Any) -> Any:
        kind, detail = node
        if kind == Nodetype.BASE:
            base = detail[0]
            return "" if base == "string" else False if base == "bool" else 0.0 if "float" in base else 0
        if kind == Nodetype.NAME:
            return self.make(detail)
        (inner, what), count = detail
        if inner == Nodetype.BASE and what[0] != "string":
            return np.zeros(count if kind == Nodetype.ARRAY else 0, dtype=what[0])
        return [self._make_zero((inner, what)) for _ in range(count if kind == Nodetype.ARRAY else 0)]


@cache
def make_messages(release: Release | None) -> Messages:
    """Return the messages of a release; its definitions are read once."""
    return Messages(release)


def full_name(kind: str) -> str:
    """Return the full name of a message type, with ``/msg/``.

    >>> full_name("nav_msgs/Path")
    'nav_msgs/msg/Path'
    """
    package, name = kind.split("/", maxsplit=1)[0], kind.rsplit("/", maxsplit=1)[-1]
    return f"{package}/msg/{name}"
