"""The weight of a kit with its core, and the places of its ballast."""

from dataclasses import dataclass

from driftform.types import Body
from driftform_frusta.kit_options import KitOptions
from driftform_kit.cutting.accounting import kit_mass
from driftform_kit.cutting.meridian import MM
from driftform_kit.cutting.pieces import make_kit


@dataclass(frozen=True)
class HeldBall:
    """A ball of ballast in the ``part`` of a kit: x of its centre and its diameter, m.

    It goes in by the joint at x = ``mouth`` (m), or, while its part is printed, by a pause at the height ``pause`` (m); the
    other one is ``None``. It is held by a ``"seat"``, or by the ``"wall"`` if the hull narrows there.
    """

    x: float
    diameter: float
    part: str
    mouth: float | None
    pause: float | None
    held_by: str


@dataclass(frozen=True)
class KitReport:
    """A kit, printed with full flow, with its core: mass (kg), x of its centre of gravity (m), the balls that it holds."""

    mass: float
    cog: float
    held: tuple[HeldBall, ...] = ()


def report_kit(body: Body, options: KitOptions) -> KitReport:
    """Return the weight of the kit of a body, and the places of its ballast.

    Raises WorkFailedError if no kit can be made of the body, or it cannot hold the balls of the options; the
    message has the reason.
    """
    kit, whole = make_kit(body, options), kit_mass(body, options)
    held = tuple(
        HeldBall(
            x=ball.ball.z / MM,
            diameter=2 * ball.ball.radius / MM,
            part=kit.pieces[ball.part].name,
            mouth=None if ball.mouth is None else kit.joints[ball.mouth].z / MM,
            pause=None if (pause := kit.find_pause(ball)) is None else pause / MM,
            held_by="wall" if ball.seat is None else "seat",
        )
        for ball in kit.ballast
    )
    return KitReport(whole.mass, float(whole.cog[0]), held)
