"""Films that nobody made: flights of an agent in a world that is known, as an imperfect camera would show them.

To check what a calibration finds: the world differs from the model by known factors, the release is by hand, and the camera
is tilted, its scale is a little wrong, its frames do not begin at the release, and every point has noise.
"""

from dataclasses import dataclass, replace

import numpy as np

from driftform.water import Factors
from driftform_calibration.bench import Bench, ReleaseError
from driftform_calibration.camera import VIEWS, Camera, see_points
from driftform_calibration.problem import RELEASE_ANGLE, RELEASE_RISE, RELEASE_SPEED, Filmed
from driftform_calibration.tracks import Track, check_track

SURFACE = -0.02
"""Height of the core's centre at which a film of a rising agent ends; the surface is at 0, m."""


@dataclass(frozen=True)
class Filming:
    """How a film is made: frames per second, noise of a point (m), and standard deviations of what else is wrong.

    Attributes:
        fps: frames per second; the release is at any time within the first frame.
        noise: of each coordinate, m.
        longest: time that is filmed, s.
        scale: relative.
        tilt: of the camera, rad.
        release: 1 for releases as by hand, 0 for exact ones.
        look_down: most angle by which the camera looks down or up, rad.
        distance: least and most distance of the camera, m.
        barrel: share by which the lens draws the corner of a picture of 16 : 9 inward, which the track fills to nine
            tenths.
        lost: share of the frames that are lost, while those that are left are numbered without a gap; negative for
            regular ones.
    """

    fps: float = 60.0
    noise: float = 0.002
    longest: float = 2.0
    scale: float = 0.005
    tilt: float = float(np.deg2rad(3.0))
    release: float = 1.0
    look_down: float = 0.0
    distance: tuple[float, float] = (2.0, 5.0)
    barrel: float = 0.0
    lost: float = 0.0


EXACT = Filming(noise=1e-5, scale=0.0, tilt=0.0, release=0.0)
"""Films without errors but those of rounding."""


def place_drop(pipeline, morphology, pitch_deg, depth=1.0):
    """Return the bench of a release from rest in a tank of that depth (m): near the surface, or near the floor if it floats."""
    bench = Bench.of(pipeline, morphology)
    start = -0.1 if bench.net_weight > 0 else 0.3 - depth
    [segment] = bench.scenario.pipe.segments
    ends = [(x, y, segment.radius - depth) for x, y, _ in (segment.start, segment.end)]
    pipe = bench.scenario.pipe.model_copy(
        update={"segments": (segment.model_copy(update={"start": ends[0], "end": ends[1]}),)}
    )
    release = bench.scenario.release.model_copy(update={"pitch_deg": float(pitch_deg), "position": (0.0, 0.0, start)})
    return replace(bench, scenario=bench.scenario.model_copy(update={"pipe": pipe, "release": release}))


def draw_world(bench, rng, spread=0.3):
    """Return factors of a world that differ from 1 by up to ``spread``; the hull's density by so much of the net weight."""
    axial, cross, added, weight, restitution, friction = rng.uniform(1 - spread, 1 + spread, 6).tolist()
    hull = 1 + (weight - 1) * bench.net_weight / bench.hull_weight
    return Factors(axial, cross, added, float(np.clip(hull, 0.3, 3.0)), restitution, friction)


def film_flight(bench, world, rng, filming=None, name="film.csv"):
    """Return a film of a flight in a world, up to the surface at z = 0."""
    how = filming or Filming()
    path = bench.fly(world, _release_by_hand(rng, how.release), how.longest)
    high = np.flatnonzero(path.position[:, 2] > SURFACE)
    end = float(path.t[high[0]]) if len(high) else float(path.t[-1])
    t = np.arange(0.0, end, 1 / how.fps)
    camera = Camera(
        rng.uniform(0.0, 1 / how.fps),
        rng.normal(0.0, how.scale),
        rng.normal(0.0, how.tilt),
        offset=(rng.normal(0.0, 0.3), rng.normal(0.0, 0.3)),
    )
    blank = Track(name, t, np.zeros((1, len(t), 2)))
    [seen] = see_points(_look_down(path, how, rng) if how.look_down else path, blank, VIEWS["side"], camera)
    if how.barrel:
        seen = _bend(seen, how.barrel, rng)
    noisy = seen + rng.normal(0.0, how.noise, seen.shape)
    if how.lost:
        kept = _keep_frames(len(t), how.lost, rng)
        noisy, blank = noisy[kept], replace(blank, t=t[: len(kept)])
    return Filmed(bench, check_track(name, replace(blank, points=noisy[None])))


def _look_down(path, how, rng):
    """Return a flight as a pinhole at a distance D sees it that looks down by p at the release, in the plane y = 0.

    Points X from the release, of depth D + X.f along the view f, appear at D (X.r, X.u) / (D + X.f). The scale is that of
    a ruler which hangs upright at the release: heights are divided by cos p.
    """
    down, distance = rng.uniform(-how.look_down, how.look_down), rng.uniform(*how.distance)
    off = path.position - path.position[0]
    depth = distance + off[:, 1] * np.cos(down) - off[:, 2] * np.sin(down)
    up = off[:, 1] * np.sin(down) + off[:, 2] * np.cos(down)
    seen = np.column_stack([off[:, 0], np.zeros(len(off)), up]) * (distance / depth)[:, None] / np.cos(down)
    return replace(path, position=path.position[0] + seen, velocity=np.gradient(seen, path.t, axis=0))


def _bend(seen, barrel, rng):
    half = np.ptp(seen, axis=0) / 2 / 0.9
    height = max(half[1], half[0] * 9 / 16)
    middle = seen.min(axis=0) + np.ptp(seen, axis=0) / 2 + rng.uniform(-0.1, 0.1, 2) * height
    off = (seen - middle) / (height * np.hypot(1.0, 16 / 9))
    bent = middle + (seen - middle) * (1 - barrel * (off**2).sum(axis=1, keepdims=True))
    return bent


def _keep_frames(count, lost, rng):
    if lost < 0:
        period = round(-1 / lost)
        return np.flatnonzero((np.arange(count) + rng.integers(period)) % period != 0)
    return np.flatnonzero(rng.uniform(size=count) >= lost)


def _release_by_hand(rng, share):
    pitch, yaw = share * rng.normal(0.0, RELEASE_ANGLE, 2)
    right, up = share * rng.normal(0.0, RELEASE_SPEED, 2)
    return ReleaseError(float(pitch), float(yaw), (float(right), 0.0, float(up)), share * rng.normal(0.0, RELEASE_RISE))
