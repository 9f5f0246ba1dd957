"""A ROS package for the UUV simulator (Gazebo classic): the agent as xacro, a world with the pipe, launch files.

The equations of that simulator are in its sources, ``uuv_gazebo_plugins/src/HydrodynamicModel.cc`` (Fossen's model) and
``BuoyantObject.cc`` (buoyancy): velocities are transformed to a frame with y to starboard and z down, in which the force
is ``-M_A a - C_A(nu) nu + (D_1 + D_2 |nu|) nu`` with positive added mass and negative damping; a is the smoothed
acceleration of the previous step. The water fills z < 0.
"""

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from driftform.interfaces import Table, option
from driftform_robotics.models.exporter import Model, ModelExporter, ModelOptions, WaterOptions
from driftform_robotics.models.gap import measure_gap, read_link
from driftform_robotics.models.link import LAGS, find_limit
from driftform_robotics.models.text import list_lines, render, roll_pitch_yaw

SMOOTHING = LAGS["the UUV simulator"]
"""Weight of the newest acceleration (``ComputeAcc`` in HydrodynamicModel.cc)."""

TO_NED = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
"""Signs of the six components in the frame of the simulator's forces (``ToNED`` in HydrodynamicModel.cc)."""


_FOLDERS = {"launch": ("start.launch", "release.launch"), "urdf": ("agent.xacro",), "worlds": ("pipe.world",)}
_FILES = [f"{folder}/{name}" for folder, names in _FOLDERS.items() for name in names]
_FILES += ["package.xml", "CMakeLists.txt", "README.md"]


class UuvOptions(ModelOptions, WaterOptions):
    """Options of the exporter for the UUV simulator."""

    depth: float = option(
        20.0,
        "depth of the origin of the pipe's frame below the water's surface, which is at z = 0; ignored if the "
        "scenario has a surface",
        "m",
        ge=0.01,
        le=1e5,
    )


class UuvExporter(ModelExporter[UuvOptions]):
    """A ROS package for the UUV simulator: xacro with a Fossen model, a world with pipe and current, launch files.

    The package holds `launch/start.launch`, `launch/release.launch`, `urdf/agent.xacro` and `worlds/pipe.world`. The
    link's origin is the centre of gravity. The simulator multiplies the added mass by the acceleration of the previous
    step, which diverges if the added mass is 17/3 of the agent's own mass or more: the export then warns.
    """

    name = "uuv"
    suffix = "-uuv"
    Options: ClassVar[type[Table]] = UuvOptions
    block = "uuv/block.xml"

    def list_values(self, model: Model) -> dict[str, Any]:
        """Return also the signs of matrices in the frame of the simulator's forces."""
        return {**super().list_values(model), "signs": np.outer(TO_NED, TO_NED)}

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return the launch files, the xacro, the world and the files of a ROS package, and the warnings."""
        scenario, link = model.job.scenario, model.link
        level = scenario.fluid.water_level
        offset = np.array([0.0, 0.0, -self.options.depth if level is None else -level])
        damping, diagonal = link.quadratic_damping, np.diag(np.diag(link.quadratic_damping))
        read = read_link("the UUV simulator", replace(link, quadratic_damping=diagonal), scenario.fluid.density)
        gap = measure_gap(replace(read, smoothing=SMOOTHING), model.job, link, self.options.step)
        axes = [axis for placed in scenario.pipe.layout.parts for axis in placed.part.list_axes(placed.part.length)]
        told = {
            "top": max((float((axis.points[:, 2] + axis.radii).max()) for axis in axes), default=-np.inf) + offset[2],
            "limit": find_limit(SMOOTHING),
            "is_diagonal": np.abs(damping - diagonal).max() <= 1e-12 * np.abs(damping).max(),
        }
        warnings = [gap.describe(), *list_lines("uuv/warnings.txt", model=model, **told)]
        x, y, z = scenario.current().tolist()
        speed = float(np.linalg.norm((x, y, z)))
        values = {
            **self.list_values(model),
            "warnings": warnings,
            "offset": offset,
            "step": gap.step,
            "angles": roll_pitch_yaw(link.rotation),
            "turn": np.roll(link.quaternion, -1),
            # Tag, mean, minimum and maximum of the parameters of the current's plugin; m/s and rad.
            "current": [
                ("velocity", speed, 0.0, max(1.0, 2 * speed)),
                ("horizontal_angle", np.arctan2(y, x), -np.pi, np.pi),
                ("vertical_angle", np.arctan2(z, np.hypot(x, y)), -np.pi, np.pi),
            ],
        }
        return {path: render(f"uuv/{path.rpartition('/')[2]}", **values) for path in _FILES}, warnings
