"""What makes a hull heavier: a cavity that is no wider than a bore, and a ball of ballast in a pocket beside the core.

The cavity is nowhere nearer to the outside than a wall. A narrower bore makes the hull heavier, continuously: the cavity stays
connected, and a bore prints without support. Ballast of any mass is a ball on the axis, as near to the core as it has room.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from driftform.agent import distance_from, mass_properties, solid_of_revolution
from driftform.types import Body, FloatArray, Moments
from driftform_frusta.cores import BallastOptions
from driftform_frusta.section import DOME_STEP

WATER = 1000.0
"""kg/m3: fresh water, in which ballast makes a buoyant body float freely."""

SPARE = 1.5
"""Maximum ballast, over that with which the body floats freely: the body must be able to sink."""

LESS = (1.2, 1.05, 1.0)
"""Smaller shares that are tried if the kit has no seat for that much."""

_GAP = 0.0003
"""m between ball and wall."""

BESIDE = 0.002
"""m between ball and core: a seat that weighs too moves the ball by as much."""

_STATIONS = 100

MIN_BORE = 0.002
"""m: least radius of a bore that stays open in print."""


@dataclass(frozen=True, eq=False)
class Cavity:
    """The widest cavity that a hull may have, and the rooms that it must have; contours as in a body, (n, 2), m."""

    widest: FloatArray
    room: FloatArray

    def narrow(self, bore: float) -> FloatArray:
        """Return the cavity that is no wider than a bore of some radius (m), but for the rooms."""
        from driftform_frusta.envelope import unite_contours

        return unite_contours(_cut_off(self.widest, bore), self.room)

    def measure(self, bore: float) -> float:
        """Return the volume of the cavity with some bore, m3."""
        return solid_of_revolution(self.narrow(bore)).volume

    @property
    def bores(self) -> tuple[float, float]:
        """The radii of the narrowest and of the widest bore, m."""
        widest = float(self.widest[:, 1].max())
        return min(MIN_BORE, widest), widest

    def fit(self, volume: float) -> FloatArray:
        """Return the cavity of some volume (m3) between the least and the greatest."""
        from scipy.optimize import brentq

        least, widest = self.bores
        if volume >= self.measure(widest):
            return self.narrow(widest)
        if volume <= self.measure(least):
            return self.narrow(least)
        bore = brentq(lambda radius: self.measure(radius) - volume, least, widest, xtol=1e-12, rtol=1e-12)
        return self.narrow(float(bore))


@dataclass(frozen=True, eq=False)
class Load:
    """A ball or none, its density (kg/m3, 0 without one), the cavity with its pocket, and the least thickness of the wall, m.

    ``masses`` are the least and the greatest mass (kg) that it adds to the hull, by the cavity that goes with the ball.
    """

    cavity: Cavity
    masses: tuple[float, float]
    ball: Moments
    density: float
    wall: float

    def add_to(self, body: Body, mass: float) -> Body:
        """Return a body with this load, whose hull and ballast weigh so much (kg) more."""
        material = (mass - self.density * self.ball.volume) / body.hull_density
        cavity = self.cavity.fit(solid_of_revolution(body.cavity).volume - material)
        return replace(body, cavity=cavity, wall=self.wall, ballast=self.ball, ballast_density=self.density)


def list_loads(
    body: Body, widest: FloatArray, room: FloatArray, options: BallastOptions, clearance: float
) -> tuple[Load, ...]:
    """Return the loads of a body without one, in ascending order of the ball's mass; the first is without a ball.

    The ``wall`` of the body is that of bodies with a load. ``widest`` is the contour of the widest cavity, (n, 2), and ``room``
    that of the room of the core, (m, 2), m; ``clearance`` is that between ball and pocket, m.
    """
    # Compiled code loads the compiler, and listing the plugins must not.
    from driftform_frusta.envelope import unite_contours

    loads = [_make_load(body, Cavity(widest, room), Moments(), 0.0)]
    for radius in options.list_radii():
        x = _find_place(body, widest, radius, clearance)
        # A wider ball leaves no ledge that holds the core.
        if x is None or radius + clearance >= body.core.radius:
            break
        united = unite_contours(room, draw_pocket(0.0, x, radius + clearance))
        loads.append(_make_load(body, Cavity(widest, united), ball_moments(x, radius), options.density))
    return tuple(loads)


def _make_load(body: Body, cavity: Cavity, ball: Moments, density: float) -> Load:
    own, (least, most) = solid_of_revolution(body.cavity).volume, map(cavity.measure, cavity.bores)
    mass = density * ball.volume
    masses = (mass + body.hull_density * (own - most), mass + body.hull_density * (own - least))
    return Load(cavity, masses, ball, density, body.wall)


def _find_place(body: Body, widest: FloatArray, radius: float, clearance: float) -> float | None:
    """Return x of a ball beside the core (m), on the side with more room; ``None`` if neither has enough."""
    aft, fore = body.core.ends
    places = np.array([aft - BESIDE - radius, fore + BESIDE + radius])
    inside = (places > widest[0, 0]) & (places < widest[-1, 0])
    rooms = np.where(inside, _distance_on_axis(places, widest), 0.0)
    for side, (place, free) in enumerate(zip(places.tolist(), rooms.tolist(), strict=True)):
        low, high = sorted((0.0, place))
        between = widest[(widest[:, 0] > low) & (widest[:, 0] < high), 1]
        rooms[side] = min(free, between.min(initial=np.inf), np.interp(place, *widest.T))
    best = int(rooms.argmax())
    return float(places[best]) if rooms[best] >= radius + clearance else None


def draw_pocket(start: float, x: float, radius: float) -> FloatArray:
    """Return the room of a ball at ``x`` on the axis, and of its way there from ``start`` (m): a bore with a round end."""
    side = 1.0 if x > start else -1.0
    angles = np.arange(0.0, np.pi / 2 + DOME_STEP / 2, DOME_STEP)
    # The polygon encloses the circle.
    corner = radius / np.cos(DOME_STEP / 2)
    end = np.column_stack((x + side * corner * np.sin(angles), corner * np.cos(angles)))
    end[-1, 1] = 0.0
    contour = np.vstack(([(start, 0.0), (start, corner)], end))
    return contour if side > 0 else contour[::-1]


def _cut_off(contour: FloatArray, radius: float) -> FloatArray:
    x, r = contour.T
    edges = np.flatnonzero(np.diff(r > radius))
    share = (radius - r[edges]) / (r[edges + 1] - r[edges])
    crossings = np.column_stack((x[edges] + share * (x[edges + 1] - x[edges]), np.full(len(edges), radius)))
    cut = np.insert(contour, edges + 1, crossings, axis=0)
    cut[:, 1] = np.minimum(cut[:, 1], radius)
    return cut


def place_ballast(body: Body, mass: float, density: float) -> Moments:
    """Return the volume integrals of a ball of some mass (kg) and density (kg/m3) at the seat, which follows from the shape.

    Raises ValueError if the ball has no room.
    """
    x, room = _find_seat(body, density)
    radius = _ball_radius(mass / density)
    if not radius <= room * (1 + 1e-9):
        most = 1000 * density * _ball_volume(room)
        raise ValueError(f"ballast of {1000 * mass:g} g cannot be placed: the hull has room for {most:.4g} g")
    return ball_moments(x, radius)


def ball_moments(x: float, radius: float) -> Moments:
    """Return the volume integrals of a ball at ``x`` on the axis."""
    volume = _ball_volume(radius)
    own = 0.2 * volume * radius**2
    return Moments(volume, volume * x, volume * x**2 + own, 2 * own)


def name_ball(ballast: Moments) -> tuple[float, float]:
    """Return x and diameter of a ball of ballast (m), in steps of 10 um, as the options of a kit have them."""
    return round(ballast.centroid, 5), round(2 * _ball_radius(ballast.volume), 5)


def find_max_ballast(body: Body, density: float) -> float:
    """Return the maximum mass of ballast, kg: limited by room, and to :data:`SPARE` of that with which the body floats freely.

    It is 0 for a body that sinks without ballast.
    """
    lacking = _find_lacking(body)
    return min(density * _ball_volume(_find_seat(body, density)[1]), SPARE * lacking) if lacking > 0 else 0.0


def _distance_on_axis(x: FloatArray, contour: FloatArray) -> FloatArray:
    return distance_from(np.column_stack((x, np.zeros_like(x))), contour)


def _find_lacking(body: Body) -> float:
    """Return the mass that a body without ballast lacks to float freely, kg."""
    bare = mass_properties(body)
    return WATER * bare.volume - bare.mass


def _ball_volume(radius: float) -> float:
    return 4 / 3 * math.pi * radius**3


def _ball_radius(volume: float) -> float:
    return math.cbrt(3 * volume / (4 * math.pi))


@lru_cache(maxsize=64)
def _find_seat(body: Body, density: float) -> tuple[float, float]:
    """Return x of the seat and the radius of the largest ball there, m; 0 without a cavity beside the core."""
    if not len(body.cavity):
        return 0.0, 0.0
    x = np.linspace(body.cavity[0, 0], body.cavity[-1, 0], _STATIONS + 2)[1:-1]
    wall = _distance_on_axis(x, body.cavity)
    aft, fore = body.core.ends
    room = np.maximum(np.minimum(wall - _GAP, np.maximum(aft - x, x - fore) - BESIDE), 0.0)
    enough = room >= _ball_radius(SPARE * max(_find_lacking(body), 0.0) / density)
    best = int(np.where(enough, np.abs(x), np.inf).argmin()) if enough.any() else int(room.argmax())
    return float(x[best]), float(room[best])
