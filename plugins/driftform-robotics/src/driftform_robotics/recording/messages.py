"""Messages of one release of ROS, made without ROS."""

from functools import cache
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from driftform_robotics.options import Release

SECOND = 1_000_000_000
"""Nanoseconds in a second."""


class Messages:
    """Makes messages of a release from plain values, and encodes them.

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

    def encode(self, kind: str, values: Any) -> bytes:
        """Return a message in CDR, or as ROS 1 serializes it.

        ``values`` are those of its fields, by name or in their order, such as ``{"linear": [1.0, 0.0, 0.0]}`` for
        ``geometry_msgs/Twist``. Fields without a value are zero or empty; those that the type lacks are left out.
        """
        name = full_name(kind)
        return bytes(self._encode(self._make(name, values), name))

    def _make(self, name: str, values: Any) -> Any:
        fields = self.store.fielddefs[name][1]
        if name not in self._zeros:
            self._zeros[name] = {key: self._make_zero(node) for key, node in fields}
        given = values if isinstance(values, dict) else dict(zip(self._zeros[name], values, strict=True))
        filled = {key: self._fill(node, given[key]) for key, node in fields if key in given}
        return self.store.types[name](**(self._zeros[name] | filled))

    def _fill(self, node: Any, value: Any) -> Any:
        kind, detail = node
        if kind == Nodetype.NAME:
            return self._make(detail, value)
        if kind == Nodetype.BASE or detail[0][0] == Nodetype.BASE:
            return value
        return [self._fill(detail[0], each) for each in value]

    def _make_zero(self, node: Any) -> Any:
        kind, detail = node
        if kind == Nodetype.BASE:
            base = detail[0]
            return "" if base == "string" else False if base == "bool" else 0.0 if "float" in base else 0
        if kind == Nodetype.NAME:
            return self._make(detail, {})
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
