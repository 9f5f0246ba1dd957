"""A close view of the agent: its shape, its attitude and its surroundings."""

import numpy as np

from driftform.figures import layout, style
from driftform.types import FloatArray
from driftform_exudyn.scene import PER_FRAME, Scene
from driftform_exudyn.shapes import Shape, make_hull, make_line, make_text, thin
from driftform_exudyn.stage import Camera, Image, Stage
from driftform_exudyn.surroundings import make_lattice

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
        shapes = [self._make_caption(scene.format_caption(frame), focus)]
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
            shapes += scene.make_water(bore, along - wide, along + wide)
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
        return [*shapes, make_line(thin(close, 3 / camera.px_per_m), style.BLUE)]

    def _make_caption(self, words: str, focus: FloatArray) -> Shape:
        camera, letters = self._camera, self._scene.letter_height
        from_middle = np.array(self._size) * (-0.5, 0.5) + np.array([1.0, -2.0]) * letters
        return make_text(focus + from_middle / camera.px_per_m @ camera.axes[:2], words, style.INK, letters)
