"""What makes a hull heavier: a cavity that is no wider than a bore, and a ball of ballast in a pocket beside the core.

The cavity is nowhere nearer to the outside than a wall. A narrower bore makes the hull heavier, continuously: the cavity stays
connected, and a bore prints without support.
"""

from dataclasses import dataclass, replace

import numpy as np

from driftform.agent import distance_from, solid_of_revolution
from driftform.types import Body, FloatArray, Moments
from driftform_frusta.ballast_seat import BESIDE, ball_moments
from driftform_frusta.pieces import BallastOptions
from driftform_frusta.section import DOME_STEP

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
    rooms = np.where(inside, distance_from(np.column_stack((places, np.zeros(2))), widest), 0.0)
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
