"""XML: elements, comments, numbers and poses as text."""

import re
import xml.etree.ElementTree as ET
from itertools import combinations_with_replacement

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

_RESERVED = ("pipe", "targets", "world")


def add(
    parent: ET.Element, tag: str, text: str | npt.ArrayLike = "", **attributes: str | npt.ArrayLike
) -> ET.Element:
    """Append an element and return it; numbers become text as by :func:`format_numbers`.

    A trailing underscore of an attribute's name is removed (``class_``).
    """
    given = {key.rstrip("_"): _format_value(value) for key, value in attributes.items()}
    found = ET.SubElement(parent, tag, given)
    found.text = _format_value(text) or None
    return found


def add_texts(parent: ET.Element, **texts: str | npt.ArrayLike) -> None:
    """Append one element for each text, by its tag."""
    for tag, text in texts.items():
        add(parent, tag, text)


def _format_value(value: str | npt.ArrayLike) -> str:
    return value if isinstance(value, str) else format_numbers(value)


def add_comment(parent: ET.Element, *lines: str) -> None:
    """Append a comment unless it is empty; two dashes, which XML does not allow in a comment, are separated."""
    text = "\n".join(line.replace("--", "- -") for line in lines)
    if text:
        parent.append(ET.Comment(f" {text} "))


def add_maintainer(parent: ET.Element) -> None:
    """Append the maintainer of a ROS package; catkin requires an address with a full domain."""
    add(parent, "maintainer", "driftform", email="driftform@example.org")


def format_document(root: ET.Element) -> str:
    """Return the text of an XML file."""
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def format_number(value: float) -> str:
    """Return a number with 12 significant digits, and zero without a minus sign."""
    return f"{value + 0.0:.12g}"


def format_numbers(values: npt.ArrayLike) -> str:
    """Return the numbers of an array in one line, row by row."""
    return " ".join(format_number(value) for value in np.ravel(values).tolist())


def format_symmetric(matrix: FloatArray, axes: str, prefix: str = "") -> dict[str, str]:
    """Return the upper triangle of a symmetric matrix, by names such as ``ixy``.

    >>> format_symmetric(np.eye(2), "xy", "i")
    {'ixx': '1', 'ixy': '0', 'iyy': '1'}
    """
    pairs = combinations_with_replacement(range(len(axes)), 2)
    return {f"{prefix}{axes[i]}{axes[j]}": format_number(matrix[i, j]) for i, j in pairs}


def roll_pitch_yaw(rotation: FloatArray) -> FloatArray:
    """Return roll, pitch and yaw (rad) of a rotation (3, 3): turns about the fixed x, y, z axes, in this order."""
    R = rotation
    pitch = np.arctan2(-R[2, 0], np.hypot(R[2, 1], R[2, 2]))
    if np.hypot(R[2, 1], R[2, 2]) < 1e-9:
        # For a vertical axis only the difference of roll and yaw is defined.
        return np.array([0.0, pitch, np.arctan2(-R[0, 1], R[1, 1])])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def format_fields(values: FloatArray, names: str = "xyz") -> str:
    """Return ``{x: 1, y: 2, z: 3}``, the syntax of YAML and of Gazebo's messages."""
    pairs = zip(names, values.tolist(), strict=True)
    return "{" + ", ".join(f"{name}: {format_number(value)}" for name, value in pairs) + "}"


def format_pose(position: FloatArray, rotation: FloatArray | None = None) -> str:
    """Return ``x y z roll pitch yaw``, m and rad, the syntax of SDF."""
    attitude = np.zeros(3) if rotation is None else roll_pitch_yaw(rotation)
    return format_numbers(np.concatenate((position, attitude)))


def make_identifier(name: str) -> str:
    """Return a name that every format and ROS accept: lower-case letters, digits and underscores, a letter first.

    >>> identifier("r1-TP3"), identifier("2 fast"), identifier("world")
    ('r1_tp3', 'agent_2_fast', 'agent_world')
    """
    kept = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_") or "agent"
    return kept if kept[0].isalpha() and kept not in _RESERVED else f"agent_{kept}"
