"""The files of a model as text: templates, and numbers, poses and comments in them."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from functools import cache
from itertools import chain, combinations_with_replacement
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

if TYPE_CHECKING:
    from jinja2 import Environment

_PLAIN = (".md", ".toml", ".txt", ".sh", ".yaml", ".in")
_RESERVED = ("pipe", "targets", "world")


def render(template: str, **values: Any) -> str:
    """Return a file from a template of this package, by its path; XML is laid out anew.

    Raises:
        xml.etree.ElementTree.ParseError: if the template is XML, and its result is not.
    """
    text = _make_environment().get_template(template).render(**values)
    if not _is_xml(template):
        return text
    ET.register_namespace("xacro", "http://www.ros.org/wiki/xacro")
    root = ET.fromstring(text.strip(), ET.XMLParser(target=ET.TreeBuilder(insert_comments=True)))
    for element in root.iter():
        if not len(element) and not (element.text or "").strip():
            element.text = None
    ET.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def list_lines(template: str, **values: Any) -> list[str]:
    """Return the lines of a template, such as warnings, without empty ones."""
    return list(filter(None, render(template, **values).splitlines()))


def _is_xml(template: str | None) -> bool:
    return template is not None and not template.endswith(_PLAIN)


@cache
def _make_environment() -> "Environment":
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    def comment(lines: Iterable[str], *more: Iterable[str]) -> Markup:
        # Two dashes end a comment.
        return Markup("\n".join(line.replace("--", "- -") for line in chain(lines, *more)))

    environment = Environment(
        loader=PackageLoader("driftform_robotics.models"),
        autoescape=_is_xml,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals |= {
        "pose": format_pose,
        "zero": np.zeros(3),
        # The indices of the upper triangle of a symmetric matrix, row by row.
        "pairs": lambda size: combinations_with_replacement(range(size), 2),
    }
    environment.filters |= {
        "comment": comment,
        # The indices of the entries that are not zero to rounding.
        "entries": lambda array: map(tuple, np.argwhere(np.abs(array) > 1e-12 * np.abs(array).max()).tolist()),
        # {x: 1, y: 2, z: 3}: the syntax of YAML and of Gazebo's messages.
        "fields": lambda values, names="xyz": (
            f"{{{', '.join(f'{name}: {format_number(v)}' for name, v in zip(names, values.tolist(), strict=True))}}}"
        ),
        "numbers": format_numbers,
        "stem": lambda path: PurePath(path).stem,
    }
    return environment


def format_number(value: float) -> str:
    """Return a number with 12 significant digits, and zero without a minus sign."""
    return f"{value + 0.0:.12g}"


def format_numbers(values: npt.ArrayLike) -> str:
    """Return the numbers of an array in one line, row by row."""
    return " ".join(format_number(value) for value in np.ravel(values).tolist())


def roll_pitch_yaw(rotation: FloatArray) -> FloatArray:
    """Return roll, pitch and yaw (rad) of a rotation (3, 3): turns about the fixed x, y, z axes, in this order."""
    R = rotation
    pitch = np.arctan2(-R[2, 0], np.hypot(R[2, 1], R[2, 2]))
    if np.hypot(R[2, 1], R[2, 2]) < 1e-9:
        # For a vertical axis only the difference of roll and yaw is defined.
        return np.array([0.0, pitch, np.arctan2(-R[0, 1], R[1, 1])])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def format_pose(position: FloatArray, rotation: FloatArray | None = None) -> str:
    """Return ``x y z roll pitch yaw``, m and rad, the syntax of SDF."""
    attitude = np.zeros(3) if rotation is None else roll_pitch_yaw(rotation)
    return format_numbers(np.concatenate((position, attitude)))


def make_identifier(name: str) -> str:
    """Return a name that every format and ROS accept: lower-case letters, digits and underscores, a letter first.

    >>> make_identifier("r1-TP3"), make_identifier("2 fast"), make_identifier("world")
    ('r1_tp3', 'agent_2_fast', 'agent_world')
    """
    kept = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_") or "agent"
    return kept if kept[0].isalpha() and kept not in _RESERVED else f"agent_{kept}"
