"""MJCF for MuJoCo: the agent in water, and a scene with the pipe.

Format: https://mujoco.readthedocs.io, "XML reference". :mod:`driftform_robotics.models.ellipsoid` describes how MuJoCo
computes the forces of the water.
"""

from typing import ClassVar

import numpy as np

from driftform.interfaces import Table
from driftform_robotics.models.ellipsoid import Ellipsoid, fit_ellipsoid
from driftform_robotics.models.exporter import PIPE, Model, ModelExporter, ModelOptions
from driftform_robotics.models.gap import COMMON_STEP, Reader, measure_gap
from driftform_robotics.models.link import Link
from driftform_robotics.models.meshes import obj_text
from driftform_robotics.models.text import render

BUOYANT_MASS = 1e-9
"""Mass of the small body on which buoyancy acts, relative to the agent's."""


class MjcfExporter(ModelExporter[ModelOptions]):
    """A model for MuJoCo: inertia, exact buoyancy, and an ellipsoid with the agent's added mass along and across.

    `scene.xml` holds the pipe and includes `agent.xml`. MuJoCo models the Coriolis forces of added mass, Munk's moment
    among them, but not its inertia: agents accelerate as if they moved no water. A warning states how far the path is from
    the true one. The body frame and the free joint are at the centre of gravity.
    """

    name = "mjcf"
    suffix = "-mjcf"
    Options: ClassVar[type[Table]] = ModelOptions

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return ``scene.xml`` and ``agent.xml``, and the warnings."""
        density = model.job.scenario.fluid.density
        ellipsoid, step = fit_ellipsoid(model.link, density), self.options.step or COMMON_STEP
        gap = measure_gap(read_mujoco(model.link, density), model.job, model.link, step)
        warnings = [gap.describe(), *_list_warnings(model, ellipsoid)]
        agent = render(
            "mujoco/agent.xml", model=model, ellipsoid=ellipsoid, step=step, warnings=warnings, negligible=BUOYANT_MASS
        )
        # The planks of a pipe with parts are hidden, and its wall is displayed in their place.
        wall = model.wall if model.job.scenario.pipe.straight is None else None
        extent = max((bore.length for bore in model.bores), default=1.0)
        if len(model.bores) > 1:
            extent = float(np.ptp([bore.position for bore in model.bores], axis=0).max())
        files = {"scene.xml": render("mujoco/scene.xml", model=model, wall=wall, extent=extent), "agent.xml": agent}
        return files | ({} if wall is None else {PIPE: obj_text(wall.mesh)}), warnings


def read_mujoco(link: Link, density: float) -> Reader:
    """Return MuJoCo in water of a density (kg/m3): without the inertia of added mass, and without linear damping."""
    none = np.zeros((6, 6))
    return Reader("MuJoCo", none, link.added_mass, none, link.quadratic_damping, density)


def _list_warnings(model: Model, ellipsoid: Ellipsoid) -> list[str]:
    link, scenario = model.link, model.job.scenario
    fluid = scenario.fluid
    surge, sway = link.added_mass[0, 0] / link.mass, link.added_mass[1, 1] / link.mass
    pitch = float(link.added_mass[4, 4] - link.added_mass[1, 5] ** 2 / link.added_mass[1, 1])
    found = [
        "MuJoCo ignores the inertia of added mass: it accelerates the agent "
        f"{1 + surge:.3g} times as fast along its axis, and {1 + sway:.3g} times as fast across it. "
        "Do not predict with this model where it goes: an agent that sinks may rise.",
        "The ellipsoid has the agent's added mass along and across its axis; in pitch it has "
        f"{ellipsoid.added_inertia(fluid.density):.3g} kg m2, and the agent {pitch:.3g} kg m2.",
        *model.list_warnings(),
    ]
    if link.linear_damping.any():
        found.append("Linear damping is left out: MuJoCo's linear damping is that of a sphere, from viscosity.")
    if fluid.water_level is not None:
        found.append("MuJoCo has no water surface: the water is everywhere.")
    return found
