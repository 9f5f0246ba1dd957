"""Where ballast of any mass lies in a hull: a ball on the axis, as near to the core as it has room."""

import math
from functools import lru_cache

import numpy as np

from driftform.agent import distance_from, mass_properties
from driftform.types import Body, Moments

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
    wall = distance_from(np.column_stack((x, np.zeros_like(x))), body.cavity)
    aft, fore = body.core.ends
    room = np.maximum(np.minimum(wall - _GAP, np.maximum(aft - x, x - fore) - BESIDE), 0.0)
    enough = room >= _ball_radius(SPARE * max(_find_lacking(body), 0.0) / density)
    best = int(np.where(enough, np.abs(x), np.inf).argmin()) if enough.any() else int(room.argmax())
    return float(x[best]), float(room[best])
