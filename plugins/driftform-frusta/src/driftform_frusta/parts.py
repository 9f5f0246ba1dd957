"""Agent -> the parts that are printed for it, each closed and ready for the bed."""

from dataclasses import dataclass

from manifold3d import Manifold

from driftform.errors import WorkFailedError
from driftform.options import option
from driftform.types import Body
from driftform_frusta.csg import Difference, Named, Node, Revolve, Translate
from driftform_frusta.kit.meridian import MM, moments, split_rings
from driftform_frusta.kit.options import KitOptions
from driftform_frusta.kit.pieces import Piece, kit_of
from driftform_frusta.printable import printable_hull, refuse_other_volume
from driftform_frusta.solid import to_manifold


class PartOptions(KitOptions):
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
    """Return the parts of a body: its sealed hull, or those of its kit, from aft to fore.

    Raises
    ------
    WorkFailedError
        where it cannot be printed this way; the message gives the reason.
    """
    if not options.kit:
        return (Part("hull", *printable_hull(body, options.segments)),)
    lift = -MM * float(body.outer[:, 0].min())
    return tuple(_part(piece, lift, options.segments) for piece in kit_of(body, options).pieces)


def _part(piece: Piece, lift: float, segments: int) -> Part:
    shape = Revolve(*split_rings(piece.rings))
    whole = to_manifold(shape, segments)
    refuse_other_volume(whole.volume(), moments(piece.rings).volume, piece.name)
    tree: Node = shape
    solid = whole
    if piece.engraved is not None:
        tree = Difference(shape, (piece.engraved.tool,))
        solid = whole - to_manifold(piece.engraved.tool, segments)
    shells = solid.decompose()
    if sum(shell.volume() > 0 for shell in shells) != 1:
        raise WorkFailedError(f"no kit can be made: its {piece.name} falls into pieces")
    label = f"{piece.name}, as joined; fore end up"
    return Part(
        piece.name,
        Named(label, Translate((0.0, 0.0, lift), tree)),
        solid.translate((0.0, 0.0, lift)),
        len(shells),
        piece.fore_down,
    )
