"""Exudyn's ray tracer as a camera: shapes -> an image, without a display."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray
from driftform.util import cores
from driftform_exudyn.headless import defer_interrupts, exudyn, items
from driftform_exudyn.scene import Pose
from driftform_exudyn.shapes import POINT_KEYS, Shape, place

Image: TypeAlias = npt.NDArray[np.uint8]
"""Rows of pixels from top to bottom, (height, width, 3), red, green and blue."""

UNIT = 100.0
"""Pixels per metre in Exudyn, whose thresholds are in metres and do not adapt to the size of the scene."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A view of the world, with the directions right, up, and towards the viewer in the world frame as rows, (3, 3).

    ``px_per_m`` is the scale at the distance of the focus, the point in the middle of the image, and ``distance`` that of the
    viewer from the focus, m; infinite for parallel lines of sight.
    """

    axes: FloatArray
    px_per_m: float
    distance: float = np.inf


class Stage:
    """A body and its surroundings in front of a camera."""

    @defer_interrupts()
    def __init__(self, body: Shape, camera: Camera, rays: int, pen: float = 2.0) -> None:
        """Add the body; a pixel is traced by ``rays`` x ``rays`` rays, and lines are ``pen`` px wide."""
        self._camera = camera
        self._scale = camera.px_per_m / UNIT
        # With perspective, Exudyn drops lines that are nearer than the origin: everything is moved behind it.
        self._away = camera.distance / 2 * self._scale if np.isfinite(camera.distance) else 0.0
        self._container = exudyn.SystemContainer()
        self._mbs = self._container.AddSystem()
        ground: Any = items.ObjectGround  # exudyn's items are partly typed, and not by what they take
        hull = place(body, self._scale, np.zeros(3))
        self._body = self._mbs.AddObject(ground(visualization=items.VObjectGround(graphicsData=[hull])))
        self._others = self._mbs.AddObject(ground())
        self._mbs.Assemble()
        settings: Any = self._container.visualizationSettings
        _set_up(settings, rays, pen)
        if self._away:
            # Close to a wide wall, all triangles of a small body are in a few branches of a default search tree.
            settings.raytracer.advanced.searchTreeFactor = 64
        # Otherwise the first image resets the view.
        self._container.renderer.ZoomAll()

    @defer_interrupts()
    def render(self, size: tuple[int, int], focus: FloatArray, pose: Pose, others: Sequence[Shape]) -> Image:
        """Return an image of ``size`` (width and height, px) with ``focus`` (world, m, (3,)) in its middle."""
        camera, scale = self._camera, self._scale
        offset = -scale * focus - self._away * camera.axes[2]
        shapes = [place(shape, scale, offset) for shape in others]
        if self._away:
            # With perspective, the size of letters refers to the origin, and is half as large at the focus.
            shapes = [
                {**shape, "fontSize": 2 * shape["fontSize"]} if "fontSize" in shape else shape for shape in shapes
            ]
        self._mbs.SetObjectParameter(self._body, "referencePosition", scale * pose.position + offset)
        self._mbs.SetObjectParameter(self._body, "referenceRotation", pose.rotation)
        self._mbs.SetObjectParameter(self._others, "VgraphicsData", shapes)
        # Exudyn does not draw beyond a few times the largest distance from the origin.
        points = (np.abs(shape[key]).max() for shape in shapes for key in POINT_KEYS if key in shape)
        self._aim(size, float(max([1.0, self._away, *points])))
        image: Image = self._container.renderer.RedrawAndGetImage(useRaytracer=True)
        return image

    def _aim(self, size: tuple[int, int], extent: float) -> None:
        view: Any = self._container.visualizationSettings.view0
        view.window.renderWindowSize = list(size)
        half = size[1] / 2 / UNIT
        view.camera.perspective = half / (2 * self._away) if self._away else 0.0
        self._container.renderer.SetState(
            {
                "modelRotation": self._camera.axes.T,
                "centerPoint": np.zeros(3),
                # The zoom refers to the origin, which is half as far from the viewer as the focus.
                "zoom": half / 2 if self._away else half,
                "maxSceneSize": extent,
            }
        )


def _set_up(settings: Any, rays: int, pen: float) -> None:
    """Show only the shapes, lit from above the viewer's left shoulder."""
    settings.general.autoFitScene = False
    settings.view0.scene.drawCoordinateSystem = 0
    settings.view0.window.showComputationInfo = False
    settings.openGL.lineWidth = pen
    settings.openGL.lightModelAmbient = [0.7, 0.7, 0.7, 1]
    settings.openGL.light1.enable = False
    light = settings.openGL.light0
    light.useCameraFrame = True
    light.position = [-1, 1.5, 3, 0]
    light.diffuse, light.specular = 0.4, 0.25
    tracer = settings.raytracer
    tracer.multiSampling = rays
    tracer.numberOfThreads = cores.count_cores()
    tracer.advanced.zBiasLines = 0.0
    tracer.material1.emission = [0.44, 0.46, 0.48]
    tracer.material1.specular = [0.0, 0.0, 0.0]
