"""Functions of kits for the builder and the exporters of driftform-frusta: parts, fittings, facts and sheet."""

from driftform.errors import WorkFailedError
from driftform.interfaces import ExportJob
from driftform.types import Body
from driftform_frusta.csg import MM, Named, Revolve, Translate
from driftform_frusta.hull import refuse_other_volume
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import Part
from driftform_frusta.solid import to_solid
from driftform_kit.cutting.accounting import measure_fittings, place_ballast
from driftform_kit.cutting.bayonet import add_details
from driftform_kit.cutting.coupon import make_coupon
from driftform_kit.cutting.meridian import moments, split_rings
from driftform_kit.cutting.pieces import Piece, add_brim, make_kit
from driftform_kit.kit import list_facts

__all__ = ["draw_sheet", "list_facts", "make_coupon", "make_parts", "measure_fittings", "place_ballast"]


def make_parts(body: Body, options: PartOptions) -> tuple[Part, ...]:
    """Return the parts of a kit, from aft to fore.

    Raises WorkFailedError if no kit can be made of the body; the message has the reason.
    """
    lift = -MM * float(body.outer[:, 0].min())
    return tuple(_make_part(piece, lift, options) for piece in make_kit(body, options).pieces)


def _make_part(piece: Piece, lift: float, options: PartOptions) -> Part:
    rings, segments = piece.rings, options.segments
    if options.brim and piece.brim:
        rings = add_brim(piece, MM * options.brim, MM * options.layer_height)
    shape = Revolve(*split_rings(rings))
    solid = to_solid(shape, segments)
    refuse_other_volume(solid.volume, moments(rings).volume, piece.name)
    tree = add_details(shape, piece.details)
    if piece.details:
        solid = to_solid(tree, segments)
    if solid.pieces != 1:
        raise WorkFailedError(f"no kit can be made: its {piece.name} falls into pieces")
    label = f"{piece.name}, as joined; fore end up"
    return Part(
        piece.name, Named(label, Translate((0.0, 0.0, lift), tree)), solid.translate((0.0, 0.0, lift)), piece.fore_down
    )


def draw_sheet(job: ExportJob, options: PartOptions, name: str) -> tuple[str, ...]:
    """Return the pages of the assembly sheet of a kit in the format ``name``, as SVG."""
    from driftform_kit.sheet.contents import plan_sheet
    from driftform_kit.sheet.drawing import draw_pages

    return draw_pages(plan_sheet(job, options, name))
