"""Kits: hulls that are cut into parts, by a distribution that the builder and the exporters find by an entry point."""

from functools import cache
from importlib import metadata
from typing import Any, Protocol

from driftform.errors import InputError
from driftform.interfaces import ExportJob
from driftform.types import Body, Fittings
from driftform_frusta.ballast_seat import name_ball
from driftform_frusta.kit_options import KitOptions, PartOptions
from driftform_frusta.parts import Part

KIT_FILE = "kit.json"
"""Name of the attachment of a 3MF file that holds the options of its kit, as JSON."""

GROUP = "driftform_frusta.kits"
"""The group of entry points."""


class KitMaker(Protocol):
    """What makes kits; each method raises a WorkFailedError if no kit can be made of a body."""

    def make_parts(self, body: Body, options: PartOptions) -> tuple[Part, ...]:
        """Return the parts of a kit, from aft to fore."""

    def make_coupon(self, body: Body, options: PartOptions) -> Part:
        """Return the fit coupon, which shows the clearance that suits a printer."""

    def measure_fittings(self, body: Body, options: KitOptions) -> Fittings:
        """Return what a kit has beside the wall of the hull: joints and seats."""

    def place_ballast(self, body: Body, options: PartOptions) -> tuple[float, float]:
        """Return x and diameter (m) of the ball that has, with its seat, the mass and the moment of a body's ballast."""

    def list_facts(self, job: ExportJob, options: PartOptions) -> dict[str, Any]:
        """Return how a kit balances, as facts of its files."""

    def draw_sheet(self, job: ExportJob, options: PartOptions, name: str) -> tuple[str, ...]:
        """Return the pages of the assembly sheet of a kit in the format ``name``, as SVG."""


@cache
def find_maker() -> KitMaker:
    """Return the installed maker of kits. Raises InputError if no such plugin is installed."""
    for point in metadata.entry_points(group=GROUP):
        maker: KitMaker = point.load()
        return maker
    raise InputError("a kit needs a distribution that makes kits; run: pip install driftform-kit")


def settle_ballast(body: Body, options: PartOptions) -> PartOptions:
    """Return options with the ballast of a body; the same ones if it has none, or if the options have ballast.

    Raises WorkFailedError if a kit cannot hold it; the message has the reason.
    """
    if not body.ballast.volume or options.ballast:
        return options
    ball = find_maker().place_ballast(body, options) if options.kit else name_ball(body.ballast)
    return options.model_copy(update={"ballast": (ball,)})


def make_parts(body: Body, options: PartOptions) -> tuple[Part, ...]:
    """Return the parts of a body: its sealed hull, or those of its kit, from aft to fore, or the fit coupon.

    Raises WorkFailedError if it cannot be printed this way; the message has the reason.
    """
    if options.coupon:
        return (find_maker().make_coupon(body, options),)
    if options.kit:
        return find_maker().make_parts(body, options)
    from driftform_frusta.printable import build_printable_hull

    return (Part("hull", *build_printable_hull(body, options.segments)),)
