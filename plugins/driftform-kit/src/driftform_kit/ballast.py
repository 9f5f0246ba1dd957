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

MIN_FILLING = 1e-3
"""m: a filling along the bore that is thinner than this cannot be laid evenly."""

_STATIONS = 240
_SLICES = 2000


def required_ballast(simulated: MassProperties, printed: MassProperties) -> MassElement:
    """Return what the printed agent lacks, of negative mass if that is buoyancy; a negligible mass is at 0."""
    mass = simulated.mass - printed.mass
    moment = float(simulated.mass * simulated.cog[0] - printed.mass * printed.cog[0])
    return MassElement(mass, 0.0 if abs(mass) < NEGLIGIBLE else moment / mass)


@dataclass(frozen=True)
class Piece:
    """A piece of ballast inside the hull: a ball of ``diameter`` (m), or a filling of the bore if that is ``None``.

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


def place_filling(body: Body, wanted: MassElement, density: float, nearest: bool = False) -> tuple[Piece, ...]:
    """Return a filling of the whole bore, such as shot or putty, of the mass and the moment of ``wanted``; empty if none fits.

    It is at least :data:`MIN_FILLING` long. With ``nearest``, it is the one at one end of the bore whose centre is nearest to
    the wanted one.
    """
    # scipy.optimize takes half a second to import, and most prints need no filling.
    from scipy.optimize import brentq

    if not _can_hold(body, wanted):
        return ()
    bore, volume, x = _Bore(body), wanted.mass / density, wanted.x
    free = float(bore.before[-1])
    if volume > free:
        return ()
    latest = free - volume

    def excess(first: float) -> float:
        return bore.fill(first, volume, density).element.x - x

    # The centre moves forward with the aft end of the filling, so that it passes x once at most.
    if nearest:
        firsts = [0.0, latest]
    elif excess(0.0) <= 0 <= excess(latest):
        firsts = [float(brentq(excess, 0.0, latest, xtol=1e-12 * free, rtol=1e-12))]
    else:
        return ()
    pieces = [bore.fill(first, volume, density) for first in firsts]
    thick = [piece for piece in pieces if piece.end - piece.start >= MIN_FILLING]
    return tuple(sorted(thick, key=lambda piece: abs(piece.element.x - x))[:1])


def place_by_hand(body: Body, wanted: MassElement, density: float) -> tuple[Piece, ...]:
    """Return ballast that can be fixed without a seat, of the wanted mass and as near as possible to the wanted place.

    A little is a ring of putty on the wall, and more is a filling of the bore; empty if neither fits.
    """
    if found := place_ring(body, wanted) or place_filling(body, wanted, density):
        return found
    if not _can_hold(body, wanted):
        return ()
    places = sorted(_stations(body), key=lambda x: abs(x - wanted.x))
    rings = (place_ring(body, MassElement(wanted.mass, float(x))) for x in places)
    return next((ring for ring in rings if ring), place_filling(body, wanted, density, nearest=True))


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


def _stations(body: Body) -> FloatArray:
    return np.linspace(body.cavity[0, 0], body.cavity[-1, 0], _STATIONS + 2)[1:-1]


def make_ball(mass: float, x: float, density: float) -> Piece:
    """Return a ball of ballast of some mass (kg) at x (m), of a material of some density (kg/m3)."""
    diameter = ball_diameter(mass, density)
    return Piece(MassElement.of_ball(mass, x, diameter / 2), x - diameter / 2, x + diameter / 2, diameter)


class _Bore:
    """The cavity around the core, as thin slices from aft to fore."""

    def __init__(self, body: Body) -> None:
        edges = np.linspace(body.cavity[0, 0], body.cavity[-1, 0], _SLICES + 1)
        self.x = (edges[1:] + edges[:-1]) / 2
        outer = np.interp(self.x, body.cavity[:, 0], body.cavity[:, 1])
        inner = body.core.radius_at(self.x)
        self.width = float(edges[1] - edges[0])
        self.edges = edges
        self.area = np.pi * np.maximum(outer**2 - inner**2, 0.0)
        self.polar = np.pi / 2 * np.maximum(outer**4 - inner**4, 0.0)
        self.before = np.concatenate(([0.0], np.cumsum(self.area * self.width)))

    def fill(self, first: float, volume: float, density: float) -> Piece:
        """Return the filling of ``volume`` (m3) that leaves the ``first`` m3 from aft empty."""
        parts = np.diff(np.clip(self.before, first, first + volume))
        share = parts / np.maximum(self.area * self.width, 1e-300)
        mass = density * parts
        whole = float(mass.sum())
        x = float(mass @ self.x / whole)
        axial = density * float((share * self.polar).sum()) * self.width
        across = axial / 2 + float(mass @ (self.x - x) ** 2)
        start, end = np.interp([first, first + volume], self.before, self.edges)
        return Piece(MassElement(whole, x, axial, across), float(start), float(end))
