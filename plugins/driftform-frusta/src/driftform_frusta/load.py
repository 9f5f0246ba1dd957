"""What makes a hull heavier: a narrower cavity, and a ball of ballast in a pocket beside the core."""

from dataclasses import dataclass, replace

import numpy as np

from driftform.agent import distance_from, solid_of_revolution
from driftform.types import Body, FloatArray, Moments
from driftform_frusta.ballast_seat import BESIDE, ball_moments
from driftform_frusta.cavity import Cavity, draw_pocket
from driftform_frusta.pieces import BallastOptions


@dataclass(frozen=True, eq=False)
class Load:
    """A ball or none, and the cavity with its pocket.

    Attributes:
        cavity: of the hull.
        masses: least and greatest mass (kg) that it adds to the hull, by the cavity that goes with the ball.
        ball: volume integrals of the ball.
        density: of the ball, kg/m3; 0 without one.
        wall: minimum thickness of the wall, m.
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
    """Return the loads of a body, in ascending order of the ball's mass; the first is without one.

    Args:
        body: without a load; its ``wall`` is that of bodies with one.
        widest: contour of the widest cavity, (n, 2), m.
        room: contour of the room of the core, (m, 2), m.
        options: of the ballast.
        clearance: between ball and pocket, m.
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
