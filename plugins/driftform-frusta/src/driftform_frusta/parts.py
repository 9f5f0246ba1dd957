"""Agent -> the parts that are printed for it, each closed and ready for the bed."""

from dataclasses import dataclass

from manifold3d import Manifold

from driftform.options import Table, option
from driftform.types import Body
from driftform_frusta.csg import Node
from driftform_frusta.printable import printable_hull


class PartOptions(Table):
    """What every exporter of meshes is asked for."""

    segments: int = option(64, "corners of every circle of the mesh", ge=12, le=1024)


@dataclass(frozen=True, eq=False)
class Part:
    """One printed piece.

    Attributes
    ----------
    name
        what people call it, in small letters: ``hull``, ``fore shell``.
    tree
        its CSG tree, in the frame of the assembled hull: mm, the axis along z, fore end up, lowest point of the
        hull at z = 0.
    solid
        the solid of that tree, mm.
    shells
        closed surfaces of the solid: its outside, and each hollow.
    fore_down
        whether it is printed with its fore end on the bed.
    """

    name: str
    tree: Node
    solid: Manifold
    shells: int
    fore_down: bool = False

    def on_bed(self) -> Manifold:
        """The solid as it is printed: upright, standing on z = 0 about the z axis, mm."""
        turned = self.solid.rotate((180.0, 0.0, 0.0)) if self.fore_down else self.solid
        return turned.translate((0.0, 0.0, -turned.bounding_box()[2]))


def parts_of(body: Body, options: PartOptions) -> tuple[Part, ...]:
    """Return the parts of a body's hull.

    Raises
    ------
    WorkFailedError
        where it cannot be printed this way; the message gives the reason.
    """
    tree, solid, shells = printable_hull(body, options.segments)
    return (Part("hull", tree, solid, shells),)
