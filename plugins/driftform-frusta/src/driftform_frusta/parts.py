"""Agent -> the parts that are printed for it, each closed and ready for the bed."""

from dataclasses import dataclass

from driftform_frusta.boundary import Solid
from driftform_frusta.csg import Node


@dataclass(frozen=True, eq=False)
class Part:
    """One printed piece.

    Attributes:
        name: in small letters: ``hull``, ``fore shell``.
        tree: its CSG tree, in the frame of the assembled hull: mm, the axis along z, fore end up, lowest point of the
            hull at z = 0.
        solid: the solid of that tree, mm.
        fore_down: whether it is printed with its fore end on the bed.
    """

    name: str
    tree: Node
    solid: Solid
    fore_down: bool = False

    def on_bed(self) -> Solid:
        """The solid as it is printed: upright, its lowest point at z = 0, mm."""
        turned = self.solid.turn_over() if self.fore_down else self.solid
        return turned.translate((0.0, 0.0, -turned.bounds[0, 2]))
