"""Both views of a film: a close one of the agent, and the whole pipe from the side."""

import numpy as np
import numpy.typing as npt

from driftform.figures import layout, style
from driftform.types import FloatArray
from driftform_exudyn.scene import PER_FRAME, Scene, interpolate_poses
from driftform_exudyn.shapes import Shape, make_hull, make_line, make_text, turn
from driftform_exudyn.stage import Camera, Image, Stage
from driftform_exudyn.surroundings import THICKNESS, make_lattice

ELEVATION = np.deg2rad(12.0)
"""Elevation of the viewer above the horizontal, rad: enough to show that the body is round."""

MIN_DISTANCE = 2.0
"""Least distance of the viewer, relative to the shorter side of the visible area."""

MARGIN = 1.3
"""Half of the shorter side of the visible area, relative to the reach of the body: the body fits in any attitude."""


class FollowView:
    """A camera that follows the middle of the body."""

    def __init__(self, scene: Scene, size: tuple[int, int], rays: int) -> None:
        self._scene, self._size = scene, size
        body = scene.agent.body
        self._middle = np.array([(body.outer[:, 0].min() + body.outer[:, 0].max()) / 2, 0.0, 0.0])
        right, up, viewer = scene.axes
        towards = np.cos(ELEVATION) * viewer + np.sin(ELEVATION) * up
        axes = np.stack([right, np.cross(towards, right), towards])
        room = 2 * MARGIN * self._reach(axes)
        # From a viewer close to a small body, the wall of a wide pipe would fill the image.
        widest = max((bore.radius for bore in scene.bores), default=0.0)
        self._camera = Camera(axes, min(size) / room, max(MIN_DISTANCE * room, widest / 2))
        self._stage = Stage(make_hull(body), self._camera, rays, scene.line_width)

    def _reach(self, axes: FloatArray) -> float:
        """Return half of the space that the body needs along the shorter side of the image, m.

        For a still it is that of the attitude shown; for a film it is enough for any attitude.
        """
        scene, outer = self._scene, self._scene.agent.body.outer - self._middle[:2]
        if scene.still is None:
            return float(np.linalg.norm(outer, axis=1).max())
        # The projected height of a ring about the axis is its radius times the sine of the angle of view.
        axis = axes[:2] @ scene.poses[scene.still].rotation[:, 0]
        half = np.abs(outer[:, :1] * axis) + outer[:, 1:] * np.sqrt(1 - axis**2)
        return float((half.max(axis=0) * min(self._size) / np.array(self._size)).max())

    def render(self, frame: int) -> Image:
        """Return a frame."""
        pose = self._scene.poses[frame]
        focus = pose.position + pose.rotation @ self._middle
        return self._stage.render(self._size, focus, pose, self._make_surroundings(frame, focus))

    def _make_surroundings(self, frame: int, focus: FloatArray) -> list[Shape]:
        scene, camera = self._scene, self._camera
        width, height = np.array(self._size) / camera.px_per_m
        shapes = [make_caption(scene, frame, self._size, focus, camera)]
        near = float(width)
        for bore in scene.bores:
            along, up, back = bore.axes @ (focus - bore.start)
            # Objects behind the agent look smaller, so that more of them is visible.
            depth = max(0.0, bore.radius - back)
            shrink = 1 + depth / camera.distance
            wide, high = 0.6 * width * shrink, 0.6 * height * shrink + depth * np.tan(ELEVATION)
            near = max(near, float(wide))
            shapes += bore.make_shapes(
                along - wide, along + wide, layout.floor_to_nice_number(wide / 2), up - high, up + high
            )
        if not scene.bores:
            behind = focus - height * scene.axes[2]
            shapes += make_lattice(
                scene.axes, behind, 2 * np.array([width, height]), layout.floor_to_nice_number(height / 2)
            )
        shapes += scene.make_targets(0.03 * height, focus, near)
        flown = scene.path_until(frame)
        here = PER_FRAME * frame
        away = np.flatnonzero(np.linalg.norm(flown - focus, axis=1) > near)
        first = away[away < here].max(initial=-1) + 1
        close = flown[first : away[away > here].min(initial=len(flown))]
        return [*shapes, make_line(layout.resample_polyline(close, 3 / camera.px_per_m), style.BLUE)]


MIN_LENGTH = 0.05
"""Length of the agent relative to the width of the image; a smaller agent is magnified."""

MAX_INTERVALS = 20
"""Largest number of intervals at which a still shows the agent."""

SMALL_LETTERS = 0.8
"""Height of the letters of distances and remarks, relative to that of other letters."""


class SideView:
    """A fixed camera."""

    def __init__(self, scene: Scene, size: tuple[int, int], rays: int, captioned: bool) -> None:
        self._scene, self._size, self._captioned = scene, np.array(size), captioned
        self._low, self._high = extent(scene)
        edge, foot = margins(scene)
        scale = ((self._size - [2 * edge, edge + foot]) / (self._high - self._low)[:2]).min()
        self._px_per_m = float(scale)
        # The margins below and above differ.
        self._centre = ((self._low + self._high) / 2 - [0.0, (foot - edge) / 2 / scale, 0.0]) @ scene.axes
        body = scene.agent.body
        length = max(body.length, body.max_diameter)
        self._magnified = max(1.0, layout.floor_to_nice_number(MIN_LENGTH * size[0] / (length * self._px_per_m)))
        self._drawn = self._magnified * length
        self._camera = Camera(scene.axes, self._px_per_m)
        self._stage = Stage(make_hull(body, self._magnified), self._camera, rays, scene.line_width)
        self._still = self._make_surroundings()

    def render(self, frame: int) -> Image:
        """Return a frame."""
        scene = self._scene
        path = layout.resample_polyline(scene.path_until(frame), 3 / self._px_per_m)
        shapes = [*self._still, make_line(path, style.BLUE)]
        if self._captioned:
            shapes.append(make_caption(scene, frame, self._size, self._centre, self._camera))
        width, height = map(int, self._size)
        return self._stage.render((width, height), self._centre, scene.poses[frame], shapes)

    def _make_surroundings(self) -> list[Shape]:
        scene, px, size = self._scene, self._px_per_m, SMALL_LETTERS * self._scene.letter_height
        shapes = []
        for bore in scene.bores:
            # The spacing leaves room for the text, or for its height if the pipe is steep.
            right, up, _ = np.abs(scene.axes @ bore.axes[0]) * px / size
            step = layout.floor_to_nice_number(2.5 / max(float(right) / 5, float(up) / 1.6))
            shapes += bore.make_shapes(0.0, bore.length, step / 2)
            # The many chords of a pipe with parts have no distances beside them.
            if len(scene.bores) == 1:
                shapes += bore.make_labels(step, size, 1.4 * scene.letter_height / px)
        if not scene.bores:
            seen = self._size / px
            shapes += make_lattice(scene.axes, self._centre, seen, layout.floor_to_nice_number(float(seen[0]) / 9))
        drawn = [f"drawn {self._magnified:g} times its size"] if self._magnified > 1 else []
        if scene.still is not None:
            t = self._exposure_times()
            drawn += [f"every {t[1]:g} s"] if len(t) > 1 else []
            hull = make_hull(scene.agent.body, self._magnified)
            shapes += [turn(hull, pose.rotation, pose.position) for pose in interpolate_poses(scene.trajectory, t)]
        if drawn:
            above = np.array([self._low[0], self._high[1] + 0.4 * scene.letter_height / px, self._high[2]])
            shapes.append(make_text(above @ scene.axes, f"agent {', '.join(drawn)}", style.MUTED, size))
        return shapes + scene.make_targets(0.3 * scene.letter_height / px, self._centre)

    def _exposure_times(self) -> FloatArray:
        """Return the times at which a still shows the agent, s: equal intervals, long enough to avoid overlaps."""
        scene, end = self._scene, float(self._scene.trajectory.t[-1])
        length = float(np.linalg.norm(np.diff(scene.path, axis=0), axis=1).sum())
        count = min(MAX_INTERVALS, length / self._drawn)
        if count < 1 or not end > 0:
            return np.zeros(1)
        step = 1 / layout.floor_to_nice_number(count / end)
        return np.asarray(np.arange(np.floor(end / step + 1e-9) + 1) * step, dtype=np.float64)


def make_caption(scene: Scene, frame: int, size: npt.ArrayLike, focus: FloatArray, camera: Camera) -> Shape:
    """Return time and place as text in the upper left corner of an image of ``size`` (px) about ``focus``, m, (3,)."""
    corner = np.asarray(size) * (-0.5, 0.5) + scene.letter_height * np.array([1.0, -2.0])
    place = focus + corner / camera.px_per_m @ camera.axes[:2]
    return make_text(place, scene.format_caption(frame), style.INK, scene.letter_height)


def extent(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return the corners of the box about the pipe, or about the path in open water, in the scene's axes, m."""
    around = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    places = [
        bore.point(along, bore.radius * (1 + THICKNESS), around) for bore in scene.bores for along in (0.0, bore.length)
    ]
    if not places:
        reach = 2 * float(np.linalg.norm(scene.agent.body.outer, axis=1).max())
        places = [scene.path + side * reach * axis for side in (-1, 1) for axis in scene.axes]
    box = np.concatenate(places) @ scene.axes.T
    return box.min(axis=0), box.max(axis=0)


def margins(scene: Scene) -> tuple[float, float]:
    """Return the margin (px) above and on either side, and the margin below, which holds the distances along a pipe."""
    return 2 * scene.letter_height, (2.2 if scene.bores else 1.0) * scene.letter_height


def wanted_height(scene: Scene, width: int) -> float:
    """Return the height (px) of an image of this width that the pipe fills."""
    low, high = extent(scene)
    edge, foot = margins(scene)
    return float((width - 2 * edge) * (high - low)[1] / (high - low)[0] + edge + foot)
