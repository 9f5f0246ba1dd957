"""Functions of kits for the builder and the exporters of driftform-frusta: parts, fittings, facts and sheet."""

from manifold3d import Manifold, OpType

from driftform.errors import WorkFailedError
from driftform.interfaces import ExportJob
from driftform.types import Body
from driftform_frusta.csg import MM, Revolve, Translate
from driftform_frusta.fittings import add_details
from driftform_frusta.hull import refuse_other_volume
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import Part
from driftform_frusta.solid import to_solid
from driftform_kit.cutting.accounting import kit_moments, measure_fittings, place_ballast
from driftform_kit.cutting.coupon import make_coupon
from driftform_kit.cutting.meridian import moments, split_rings
from driftform_kit.cutting.pieces import Piece, make_kit
from driftform_kit.kit import list_facts
from driftform_kit.source import write_kit

__all__ = ["draw_sheet", "list_facts", "make_coupon", "make_parts", "measure_fittings", "place_ballast", "write_kit"]


_MEETS = 1e-4
"""Relative difference of volumes that facets explain."""


def make_parts(body: Body, options: PartOptions) -> tuple[Part, ...]:
    """Return the parts of a kit, from aft to fore.

    Raises WorkFailedError if no kit can be made of the body; the message has the reason.
    """
    lift, kit = -MM * float(body.outer[:, 0].min()), make_kit(body, options)
    parts = tuple(_make_part(piece, lift, options) for piece in kit.pieces)
    if body.fittings.details:
        whole = Manifold.batch_boolean([part.solid.to_manifold() for part in parts], OpType.Add).volume()
        expected = MM**3 * kit_moments(kit).volume
        if abs(whole - expected) > _MEETS * expected:
            raise WorkFailedError("no kit can be made: what is fitted meets a joint or a seat; fit it at another place")
    return parts


def _make_part(piece: Piece, lift: float, options: PartOptions) -> Part:
    shape = Revolve(*split_rings(piece.rings))
    solid = to_solid(shape, options.segments)
    refuse_other_volume(solid.volume, moments(piece.rings).volume, piece.name)
    tree = add_details(shape, piece.details)
    if piece.details:
        solid = to_solid(tree, options.segments)
    if solid.pieces != 1:
        raise WorkFailedError(f"no kit can be made: its {piece.name} falls into pieces")
    at = (0.0, 0.0, lift)
    return Part(piece.name, Translate(at, tree), solid.translate(at), piece.fore_down)


def draw_sheet(job: ExportJob, options: PartOptions, name: str) -> tuple[str, ...]:
    """Return the pages of the assembly sheet of a kit in the format ``name``, as SVG."""
    from driftform_kit.sheet.contents import plan_sheet
    from driftform_kit.sheet.drawing import draw_pages

    return draw_pages(plan_sheet(job, options, name))
