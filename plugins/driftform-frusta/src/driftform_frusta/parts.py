"""The parts that are printed for an agent: its sealed hull, or a kit, which driftform-kit makes when it is asked for."""

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import ModuleType

from driftform.errors import InputError
from driftform.types import Body
from driftform_frusta.cores import is_sold
from driftform_frusta.csg import MM, Node, Translate
from driftform_frusta.fittings import add_details
from driftform_frusta.hull import build_printable_hull, printed_volume, refuse_other_volume
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.load import name_ball
from driftform_frusta.solid import Solid, to_solid

KIT_FILE = "kit.json"
"""Name of the attachment of a 3MF file that holds the options of its kit, as JSON."""


@dataclass(frozen=True, eq=False)
class Part:
    """One printed piece: its name, such as ``hull`` or ``fore shell``, its CSG tree, and the solid of that, mm.

    The tree is in the frame of the assembled hull: mm, the axis along z, fore end up, lowest point of the hull at z = 0.
    ``fore_down`` is whether it is printed with its fore end on the bed.
    """

    name: str
    tree: Node
    solid: Solid
    fore_down: bool = False

    def on_bed(self) -> Solid:
        """The solid as it is printed: upright, its lowest point at z = 0, mm."""
        turned = self.solid.turn_over() if self.fore_down else self.solid
        return turned.translate((0.0, 0.0, -turned.bounds[0, 2]))


@cache
def find_maker() -> ModuleType:
    """Return the module that makes kits, which depends on this distribution. Raises InputError if it is not installed."""
    try:
        return import_module("driftform_kit.maker")
    except ModuleNotFoundError:
        raise InputError("a kit needs a distribution that makes kits; run: pip install driftform-kit") from None


def settle_ballast(body: Body, options: PartOptions) -> PartOptions:
    """Return options with the ballast of a body; the same ones if it has none, or if the options have ballast.

    A ball that is sold in sizes is the one of the body, which counts its seat; one of any mass is smaller by its seat.

    Raises WorkFailedError if a kit cannot hold it; the message has the reason.
    """
    if not body.ballast.volume or options.ballast:
        return options
    ball, options = name_ball(body.ballast), options.model_copy(update={"ballast_density": body.ballast_density})
    if options.kit and not is_sold(ball[1], body.ballast_density):
        ball = find_maker().place_ballast(body, options)
    return options.model_copy(update={"ballast": (ball,)})


def make_parts(body: Body, options: PartOptions) -> tuple[Part, ...]:
    """Return the parts of a body: its sealed hull, or those of its kit, from aft to fore, or the fit coupon.

    Raises WorkFailedError if it cannot be printed this way; the message has the reason.
    """
    if options.coupon:
        return (find_maker().make_coupon(body, options),)
    if options.kit:
        parts: tuple[Part, ...] = find_maker().make_parts(body, options)
        return parts
    tree, solid = build_printable_hull(body, options.segments)
    if body.fittings.details:
        lift = MM * float(body.outer[:, 0].min())
        fitted = add_details(Translate((0.0, 0.0, lift), tree), body.fittings.details)
        tree = Translate((0.0, 0.0, -lift), fitted)
        solid = to_solid(tree, options.segments)
        refuse_other_volume(solid.volume, printed_volume(body), "hull with its fittings", 1e-4)
    return (Part("hull", tree, solid),)
