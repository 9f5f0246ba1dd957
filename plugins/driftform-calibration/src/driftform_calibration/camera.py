"""A flight as a film shows it: points of the axis in the plane of the picture, with the camera's own errors."""

from dataclasses import dataclass

import numpy as np

from driftform.types import FloatArray
from driftform_calibration.bench import Path
from driftform_calibration.tracks import Track

VIEWS = {
    "side": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "top": np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "front": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
}
"""The world directions that point to the right and up in a picture, by the name of the view."""


@dataclass(frozen=True)
class Camera:
    """How a film's coordinates differ from those of the world.

    Attributes:
        delay: time of the release in the film, s.
        scale: logarithm of the film's lengths over those of the world.
        tilt: turn of the picture, counterclockwise, rad; a track in space has none.
        aspect: logarithm of the width of the picture over that without distortion: the agent moves a little towards
            the camera, or the camera looks a little down, which shortens heights.
        keystone: shrinking of the picture with the depth below the release, 1/m: a camera at the distance D that
            looks down by the angle p sees what is lower from farther away, and has sin(p) / D (a pinhole, to first
            order in the angle).
        barrel: share by which the lens draws the ends of the track towards its middle; it grows with the square of
            the distance (Brown 1966, Photogrammetric Engineering 32(3), first radial term).
        offset: film coordinates of the world's origin, m, (2,) or (3,).
    """

    delay: float = 0.0
    scale: float = 0.0
    tilt: float = 0.0
    aspect: float = 0.0
    keystone: float = 0.0
    barrel: float = 0.0
    offset: tuple[float, ...] = (0.0, 0.0)


def see_points(path: Path, track: Track, view: FloatArray, camera: Camera) -> FloatArray:
    """Return where a film shows the markers, m, (markers, n, d)."""
    core, axis = path.points_at(track.t - camera.delay)
    stretch = np.array([np.exp(camera.aspect), *[1.0] * (len(view) - 1)])
    turn = stretch[:, None] * view
    if len(view) == 2:
        c, s = np.cos(camera.tilt), np.sin(camera.tilt)
        turn = np.array([[c, -s], [s, c]]) @ turn
    start = path.position[0]
    seen = np.array([core + place * axis - start for place in track.places])
    seen = seen / (1 - camera.keystone * (seen @ view[1]))[..., None]
    points = bend_points((start + seen) @ turn.T, camera.barrel)
    return np.asarray(np.exp(camera.scale) * points + np.array(camera.offset))


def bend_points(points: FloatArray, barrel: float) -> FloatArray:
    """Return points of a picture, (markers, n, d), drawn towards their middle by the share ``barrel`` of the farthest."""
    off = points - points.mean(axis=(0, 1))
    square = (off**2).sum(axis=-1, keepdims=True)
    return np.asarray(points - barrel * square / max(float(square.max()), 1e-12) * off)
