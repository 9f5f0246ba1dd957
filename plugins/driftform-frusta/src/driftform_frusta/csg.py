"""Solids as trees of plain values, in the manner of OpenSCAD.

A tree describes a solid; :mod:`driftform_frusta.solid` makes a mesh of it, and
:mod:`driftform_frusta.scad` prints it as OpenSCAD source. All lengths are millimetres, because a tree
describes what a printable file holds; angles are degrees, in fields that end in ``_deg``. A tree knows
nothing of facets: radii are those of true circles, and it is the interpreters that approximate them.
"""

from dataclasses import dataclass
from typing import TypeAlias

MM = 1e3
"""Millimetres in a metre: solids and files are in mm."""

Point: TypeAlias = tuple[float, float]
"""A point (r, z) of a meridian half-plane, or (x, y) of a section, mm."""

Vector: TypeAlias = tuple[float, float, float]
"""x, y, z."""


@dataclass(frozen=True)
class Revolve:
    """A meridian section revolved about z, all round or from the half-plane of x > 0 by ``angle_deg``.

    ``outline`` and each of ``holes`` is a closed polygon of (r, z) points, in either sense of rotation, the
    last joined to the first; the holes are subtracted from the outline before it is revolved. What lies at
    r < 0 is cut off. With a ``rise`` it winds upward, by so much in all, and may turn round more than once: a thread, without holes.
    """

    outline: tuple[Point, ...]
    holes: tuple[tuple[Point, ...], ...] = ()
    angle_deg: float = 360.0
    rise: float = 0.0


@dataclass(frozen=True)
class Extrude:
    """A section in the plane z = 0 that is lifted from there to ``height``: a plate, such as a fin.

    ``outline`` and ``holes`` are as those of :class:`Revolve`, of points (x, y).
    """

    outline: tuple[Point, ...]
    holes: tuple[tuple[Point, ...], ...]
    height: float


@dataclass(frozen=True)
class Union:
    """All points of any of the children."""

    children: "tuple[Node, ...]"


@dataclass(frozen=True)
class Difference:
    """The points of ``base`` that belong to none of the ``tools``."""

    base: "Node"
    tools: "tuple[Node, ...]"


@dataclass(frozen=True)
class Intersection:
    """The points that all children have in common."""

    children: "tuple[Node, ...]"


@dataclass(frozen=True)
class Translate:
    """The child moved by ``offset``."""

    offset: Vector
    child: "Node"


@dataclass(frozen=True)
class Rotate:
    """The child turned by ``angles_deg`` about the fixed x, y and z axes, in this order, as OpenSCAD's ``rotate`` does."""

    angles_deg: Vector
    child: "Node"


Node: TypeAlias = Revolve | Extrude | Union | Difference | Intersection | Translate | Rotate
"""Any solid."""
