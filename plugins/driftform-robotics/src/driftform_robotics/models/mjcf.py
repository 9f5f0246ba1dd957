"""MJCF for MuJoCo: the agent in water, and a scene with the pipe.

Format: https://mujoco.readthedocs.io, "XML reference". :mod:`driftform_robotics.models.ellipsoid` describes how MuJoCo
computes the forces of the water.
"""

from dataclasses import replace
from typing import ClassVar

import numpy as np

from driftform.interfaces import Table
from driftform.types import FloatArray
from driftform_robotics.models.ellipsoid import added_mass, fit_ellipsoids
from driftform_robotics.models.exporter import PIPE, Model, ModelExporter, ModelOptions
from driftform_robotics.models.gap import COMMON_STEP, Reader, coriolis_products, measure_gap
from driftform_robotics.models.link import move_to_mass
from driftform_robotics.models.meshes import obj_text
from driftform_robotics.models.text import list_lines, render

SHARE = 0.9
"""Share of the least added mass that is in the mass of the file; the ellipsoid has the rest."""

BUOYANT_MASS = 1e-9
"""Mass of the small body on which buoyancy acts, relative to the agent's."""


class MjcfExporter(ModelExporter[ModelOptions]):
    """A model for MuJoCo: exact weight in water, and ellipsoids with the agent's added mass, drag and lift.

    `scene.xml` holds the pipe and includes `agent.xml`. MuJoCo models the Coriolis forces of added mass, Munk's moment
    among them, but not its inertia, of which mass and inertia in the file have what they can. A warning states how far the
    path is from the true one. The body frame and the free joint are at the centre of gravity.
    """

    name = "mjcf"
    suffix = "-mjcf"
    Options: ClassVar[type[Table]] = ModelOptions

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return ``scene.xml`` and ``agent.xml``, and the warnings."""
        fluid, step = model.job.scenario.fluid, self.options.step or COMMON_STEP
        own = model.link.added_mass
        mass = SHARE * float(min(own[0, 0], own[1, 1]))
        link = move_to_mass(model.link, mass, 0.5 * float(own[4, 4] + own[5, 5]), fluid.density)
        ellipsoids = fit_ellipsoids(model.job, link)
        gap = measure_gap(read_mujoco(ellipsoids, fluid.density), model.job, link, step)
        warnings = [gap.describe(), *list_lines("mujoco/warnings.txt", model=model, link=link)]
        agent = render(
            "mujoco/agent.xml",
            model=replace(model, link=link),
            mass=mass,
            ellipsoids=ellipsoids,
            step=step,
            warnings=warnings,
            negligible=BUOYANT_MASS,
        )
        # The planks of a pipe with parts are hidden, and its wall is displayed in their place.
        wall = model.wall if model.job.scenario.pipe.straight is None else None
        extent = max((bore.length for bore in model.bores), default=1.0)
        if len(model.bores) > 1:
            extent = float(np.ptp([bore.position for bore in model.bores], axis=0).max())
        files = {"scene.xml": render("mujoco/scene.xml", model=model, wall=wall, extent=extent), "agent.xml": agent}
        return files | ({} if wall is None else {PIPE: obj_text(wall)}), warnings


def read_mujoco(ellipsoids: FloatArray, density: float) -> Reader:
    """Return MuJoCo in water of a density (kg/m3): without the inertia of added mass, and without linear damping."""
    none, products = np.zeros((6, 6)), np.zeros((2, 6, 6, 6))
    for a, b, x, *_ in ellipsoids.tolist():
        products[1] += coriolis_products(added_mass(a, b, x, density))
    return Reader("MuJoCo", none, none, products, density, ellipsoids=ellipsoids, is_checked=True)
