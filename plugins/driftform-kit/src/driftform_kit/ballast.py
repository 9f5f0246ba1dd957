"""Ballast that gives a printed agent the mass and the balance of the simulated one: mass, position and shape.

For the simulated mass m0 at x0 and the printed mass m at x, the ballast is the difference of mass and moment::

    m_b = m0 - m,    x_b = (m0 x0 - m x) / m_b

It lies inside the hull and displaces no water. If the print is too heavy, m_b is negative, and x_b is where buoyancy
must be added.
"""

from dataclasses import dataclass

import numpy as np

from driftform.agent import MassElement, distance_from
from driftform.types import Body, FloatArray, MassProperties

MATERIALS = {"steel": 7850.0, "lead": 11_340.0, "tungsten": 19_250.0}
"""Densities of ballast, kg/m3 (CRC Handbook of Chemistry and Physics, at 20 degrees C)."""

_SAME_MATERIAL = 0.01
"""Share by which the density of a named material may differ."""

FOAM = 35.0
"""Density of extruded polystyrene foam, kg/m3 (EN 13164: 25 to 45)."""

PUTTY = 1800.0
"""Density of epoxy putty, kg/m3: data sheets state 1600 to 2000."""

NEGLIGIBLE = 1e-6
"""kg: ballast below a milligram is not needed."""

_STATIONS = 240


def required_ballast(simulated: MassProperties, printed: MassProperties) -> MassElement:
    """Return what the printed agent lacks, of negative mass if that is buoyancy; a negligible mass is at 0."""
    mass = simulated.mass - printed.mass
    moment = float(simulated.mass * simulated.cog[0] - printed.mass * printed.cog[0])
    return MassElement(mass, 0.0 if abs(mass) < NEGLIGIBLE else moment / mass)


@dataclass(frozen=True)
class Piece:
    """A piece of ballast inside the hull: a ball of ``diameter`` (m), or a ring of putty on the wall if that is ``None``.

    It lies between ``start`` and ``end`` (x, m). ``putty`` is how much of its mass is epoxy putty, kg; a ring on the wall is
    ``ring`` thick, m.
    """

    element: MassElement
    start: float
    end: float
    diameter: float | None = None
    putty: float = 0.0
    ring: float | None = None


def ball_diameter(mass: float, density: float) -> float:
    """Return the diameter (m) of a ball of that mass (kg) and density (kg/m3)."""
    return float(np.cbrt(6 * mass / (np.pi * density)))


def name_material(density: float) -> str:
    """Return the name of a density (kg/m3): ``lead``, or the density where no material of :data:`MATERIALS` has it."""
    named = (name for name, usual in MATERIALS.items() if abs(density - usual) <= _SAME_MATERIAL * usual)
    return next(named, f"{density:g} kg/m3")


def place_one_ball(body: Body, wanted: MassElement, density: float) -> tuple[Piece, ...]:
    """Return a ball on the axis of the mass and the moment of ``wanted``, beside the core; empty if it has no room.

    The density is that of the ballast, kg/m3.
    """
    if not _can_hold(body, wanted):
        return ()
    piece = make_ball(wanted.mass, wanted.x, density)
    room = max_ball_radius(body, np.array([wanted.x]))
    return (piece,) if room[0] >= piece.element.x - piece.start else ()


def place_by_hand(body: Body, wanted: MassElement) -> tuple[Piece, ...]:
    """Return what needs no seat: a ring of putty on the wall, as near as possible to the wanted place; empty if none fits."""
    if not _can_hold(body, wanted):
        return ()
    places = np.linspace(body.cavity[0, 0], body.cavity[-1, 0], _STATIONS + 2)[1:-1].tolist()
    rings = (
        place_ring(body, MassElement(wanted.mass, x))
        for x in sorted((wanted.x, *places), key=lambda x: abs(x - wanted.x))
    )
    return next((ring for ring in rings if ring), ())


def place_ring(body: Body, wanted: MassElement) -> tuple[Piece, ...]:
    """Return a ring of epoxy putty on the wall, as thick as it is wide, of the wanted mass and moment; empty if it has no room.

    It leaves half of the bore's radius free.
    """
    from scipy.optimize import brentq

    if not _can_hold(body, wanted):
        return ()
    x, volume = wanted.x, wanted.mass / PUTTY
    bore = float(np.interp(x, body.cavity[:, 0], body.cavity[:, 1]))
    if np.pi * (bore**2 - (bore / 2) ** 2) * bore / 2 < volume:
        return ()
    thick = float(brentq(lambda s: np.pi * (bore**2 - (bore - s) ** 2) * s - volume, 0.0, bore / 2))
    start, end, inner = x - thick / 2, x + thick / 2, bore - thick
    beside_core = float(body.core.radius_at(np.clip(0.0, start, end))) <= inner
    if not beside_core or start < body.cavity[0, 0] or end > body.cavity[-1, 0]:
        return ()
    axial = wanted.mass * (bore**2 + inner**2) / 2
    element = MassElement(wanted.mass, x, axial, axial / 2 + wanted.mass * thick**2 / 12)
    return (Piece(element, start, end, None, wanted.mass, thick),)


def _can_hold(body: Body, wanted: MassElement) -> bool:
    return bool(len(body.cavity)) and wanted.mass >= NEGLIGIBLE


def max_ball_radius(body: Body, x: FloatArray) -> FloatArray:
    """Return the radius (m) of the largest ball that has room at each ``x`` (n,) on the axis, beside the core, or 0.

    How a ball gets there is up to the kit.
    """
    aft, fore = body.core.ends
    inside = (x > body.cavity[0, 0]) & (x < body.cavity[-1, 0])
    wall = np.where(inside, distance_from(np.column_stack((x, np.zeros_like(x))), body.cavity), 0.0)
    return np.asarray(np.maximum(np.minimum(wall, np.maximum(aft - x, x - fore)), 0.0))


def make_ball(mass: float, x: float, density: float) -> Piece:
    """Return a ball of ballast of some mass (kg) at x (m), of a material of some density (kg/m3)."""
    diameter = ball_diameter(mass, density)
    return Piece(MassElement.of_ball(mass, x, diameter / 2), x - diameter / 2, x + diameter / 2, diameter)
