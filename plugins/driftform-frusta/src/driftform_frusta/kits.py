"""Kits: hulls that are cut into parts by driftform-kit, which the builder and the exporters import when they need it."""

from functools import cache
from importlib import import_module
from types import ModuleType

from driftform.errors import InputError
from driftform.types import Body
from driftform_frusta.ballast_seat import name_ball
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import Part

KIT_FILE = "kit.json"
"""Name of the attachment of a 3MF file that holds the options of its kit, as JSON."""


@cache
def find_maker() -> ModuleType:
    """Return the module that makes kits, which depends on this distribution. Raises InputError if it is not installed."""
    try:
        return import_module("driftform_kit.maker")
    except ModuleNotFoundError:
        raise InputError("a kit needs a distribution that makes kits; run: pip install driftform-kit") from None


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
        parts: tuple[Part, ...] = find_maker().make_parts(body, options)
        return parts
    from driftform_frusta.printable import build_printable_hull

    return (Part("hull", *build_printable_hull(body, options.segments)),)
