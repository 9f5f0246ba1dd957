"""Agent -> the parts that are printed for it, each closed and ready for the bed."""

from dataclasses import dataclass

from driftform.errors import WorkFailedError
from driftform.types import Body
from driftform_frusta.boundary import Solid
from driftform_frusta.csg import Difference, Named, Node, Revolve, Translate
from driftform_frusta.kit.meridian import MM, moments, split_rings
from driftform_frusta.kit.options import PartOptions
from driftform_frusta.kit.pieces import Piece, make_kit
from driftform_frusta.printable import build_printable_hull, refuse_other_volume
from driftform_frusta.solid import to_manifold, to_solid


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
    fore_down
        whether it is printed with its fore end on the bed.
    """

    name: str
    tree: Node
    solid: Solid
    fore_down: bool = False

    def on_bed(self) -> Solid:
        """The solid as it is printed: upright, its lowest point at z = 0, mm."""
        turned = self.solid.turn_over() if self.fore_down else self.solid
        return turned.translate((0.0, 0.0, -turned.bounds[0, 2]))


def make_parts(body: Body, options: PartOptions) -> tuple[Part, ...]:
    """Return the parts of a body: its sealed hull, or those of its kit, from aft to fore.

    Raises
    ------
    WorkFailedError
        if it cannot be printed this way; the message has the reason.
    """
    if not options.kit:
        return (Part("hull", *build_printable_hull(body, options.segments)),)
    lift = -MM * float(body.outer[:, 0].min())
    return tuple(_make_part(piece, lift, options.segments) for piece in make_kit(body, options).pieces)


def _make_part(piece: Piece, lift: float, segments: int) -> Part:
    shape = Revolve(*split_rings(piece.rings))
    solid = to_solid(shape, segments)
    refuse_other_volume(solid.volume, moments(piece.rings).volume, piece.name)
    tree: Node = shape
    if piece.engraved is not None:
        tree = Difference(shape, (piece.engraved.tool,))
        solid = Solid.from_manifold(solid.to_manifold() - to_manifold(piece.engraved.tool, segments))
    if solid.pieces != 1:
        raise WorkFailedError(f"no kit can be made: its {piece.name} falls into pieces")
    label = f"{piece.name}, as joined; fore end up"
    return Part(
        piece.name,
        Named(label, Translate((0.0, 0.0, lift), tree)),
        solid.translate((0.0, 0.0, lift)),
        piece.fore_down,
    )
