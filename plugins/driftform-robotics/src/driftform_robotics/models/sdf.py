"""SDF for Gazebo: a model of the agent, and a world with the pipe, the water and the current.

Gazebo's equations are in its sources: gz-sim, ``src/systems/hydrodynamics`` and ``src/systems/buoyancy``; gz-physics,
``dartsim/src/AddedMassFeatures.cc``. Format: http://sdformat.org/spec.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np

from driftform.agent import slice_solid
from driftform.interfaces import Table, option
from driftform.water import Scenario
from driftform_robotics.models.exporter import HULL, PIPE, Model, ModelExporter, ModelOptions
from driftform_robotics.models.fitting import fit_products
from driftform_robotics.models.gap import Gap, Reader, coriolis_products, measure_gap
from driftform_robotics.models.link import describe_link, move_to_mass
from driftform_robotics.models.meshes import obj_text
from driftform_robotics.models.ros2 import make_package
from driftform_robotics.models.text import list_lines, render

WORLD = "driftform"
"""Name of the world in Gazebo."""

PUSH = {"world.sdf": "push.sh", "drift.sdf": "push_drift.sh"}
"""Script that releases the agent in each world."""

_MAX_SPHERES = 40


class SdfOptions(ModelOptions):
    """Options of the exporter for Gazebo."""

    gazebo: Literal["harmonic", "fortress"] = option(
        "harmonic",
        "release of Gazebo: 'harmonic' and later read SDF 1.11; 'fortress' reads SDF 1.9 and multiplies the added mass "
        "by the acceleration of the previous step",
    )


@dataclass(frozen=True)
class _Gazebo:
    """The names that a release of Gazebo uses, and whether it solves the added mass together with the mass."""

    sdf: str
    system: str
    namespace: str
    messages: str
    program: str
    solves_added_mass: bool


_GAZEBO = {
    "harmonic": _Gazebo("1.11", "gz-sim", "gz::sim", "gz.msgs", "gz", True),
    "fortress": _Gazebo("1.9", "ignition-gazebo", "ignition::gazebo", "ignition.msgs", "ign", False),
}


class SdfExporter(ModelExporter[SdfOptions]):
    """A model for Gazebo and a world with pipe, water, current and buoyancy, ready for `gz sim world.sdf`.

    The folder is a ROS 2 package with a launch file and a bridge, and works without ROS too. It holds `world.sdf`,
    `model.sdf` with its `model.config`, and meshes; also `push.sh` if the agent is
    released with a velocity, and `drift.sdf` if there is a current: the same world in the frame of the water, where the
    pipe moves past water at rest. Gazebo's treatment of added mass is exact there, but not in a current.

    The link's origin is the centre of gravity. The added mass is `<fluid_added_mass>`, which DART, Gazebo's default
    engine, solves together with the mass. The hull collides, and displaces water, as closed convex pieces.
    """

    name = "sdf"
    suffix = "-sdf"
    Options: ClassVar[type[Table]] = SdfOptions
    block = "gazebo/block.xml"

    def list_values(self, model: Model) -> dict[str, Any]:
        """Return also the names that the release of Gazebo uses, and forces per product of rates, as the plugin reads them.

        For Fortress a part of the added mass is in the mass, and the Coriolis forces of the rest are products of rates: those
        that the plugin computes itself have the opposite sign.
        """
        gazebo, density = _GAZEBO[self.options.gazebo], model.job.scenario.fluid.density
        products = fit_products(model.job, model.link)
        # The pieces displace the water in trim pockets too, which flies with the agent.
        x, hull, _ = slice_solid(model.job.agent.body.outer, 1)[0].tolist()
        mass, inertia = density * max(hull - model.link.volume, 0.0), 0.0
        if not gazebo.solves_added_mass:
            # As much that what lags is less than the mass in every motion: with half, two of 24 random agents diverged.
            own = np.diag(model.link.added_mass)
            if model.job.scenario.fluid.water_level is None:
                mass = max(mass, 0.7 * float(own[:3].max()))
            inertia = 0.35 * float(own[4] + own[5])
        link = move_to_mass(model.link, mass, inertia, density)
        model = replace(model, link=replace(link, buoyancy=hull / link.volume * model.axis_point(x)))
        if not gazebo.solves_added_mass:
            products[1] += coriolis_products(model.link.added_mass)
        notes = describe_link(model.job.name, model.link, is_fitted=True)
        return {"gazebo": gazebo, "model": model, "products": products, "notes": notes}

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return the worlds, the model, the mesh of the pipe and the scripts of the release, and the warnings."""
        scenario = model.job.scenario
        water = self.list_values(model)
        gazebo, model = water["gazebo"], water["model"]
        body, slices = model.job.agent.body, list[tuple[float, float]]()
        if scenario.fluid.water_level is not None:
            # x (m) and volume (m3) of slices of the hull, which spheres replace.
            count = int(np.clip(round(1.5 * body.length / body.max_diameter), 4, _MAX_SPHERES))
            slices = [(x, part) for x, part, _ in slice_solid(body.outer, count)]
        elif (beyond := model.link.volume - slice_solid(body.outer, 1)[0, 1]) > 1e-9:
            # It carries the weight of the added mass that is in the mass.
            slices = [(float(model.job.agent.mass.cog[0]), beyond)]
        spheres = [(x, float(np.cbrt(0.75 * part / np.pi))) for x, part in slices]
        worlds = {"world.sdf": model}
        # Nothing moves evenly with the water through a bend.
        if scenario.current().any() and (scenario.pipe.is_open or scenario.pipe.straight is not None):
            worlds["drift.sdf"] = _move_to_water_frame(model)
        values = {**water, "world": WORLD, "spheres": spheres, "flown": scenario, "worlds": worlds}
        made, found = dict[str, str](), dict[str, list[str]]()
        for name, here in worlds.items():
            gap = _measure_gap(here, water, name, self.options.step)
            own = {**values, "model": here, "file": name, "push": PUSH[name], "step": gap.step}
            own["passing"] = None if here is model else -scenario.current()
            found[name] = [gap.describe(), *list_lines("gazebo/warnings.txt", **own)]
            made[name] = render("gazebo/world.sdf", **own, warnings=found[name])
            if here.link.velocity.any():
                made[PUSH[name]] = render("gazebo/push.sh", **own)
        files = {
            "world.sdf": made["world.sdf"],
            "model.sdf": render("gazebo/model.sdf", **values, warnings=found["world.sdf"]),
            "model.config": render("gazebo/model.config", **values),
            **({} if model.wall is None else {PIPE: obj_text(model.wall)}),
            **made,
        }
        *_, first = worlds
        warnings = [*(found[name][0] for name in worlds if name != "world.sdf"), *found["world.sdf"]]
        package = make_package(
            f"{model.title}_gazebo",
            f"The agent {model.job.name} of driftform in its pipe, for Gazebo",
            [*files, HULL],
            "gazebo/start.launch.py.in",
            ("launch", "launch_ros", "ros_gz_bridge", "ros_gz_sim"),
            {"config/bridge.yaml": render("gazebo/bridge.yaml", **values)},
            model=model,
            gazebo=gazebo,
            first=first,
            push=PUSH[first],
            warnings=warnings,
        )
        return files | package, warnings


def _move_to_water_frame(model: Model) -> Model:
    """Return the model in the frame of the water, where the pipe moves and the current does not: motion is the same."""
    scenario = model.job.scenario
    velocity = model.link.velocity - scenario.current()
    x, y, z = velocity.tolist()
    calm = {
        "flow": Scenario().flow.model_copy(update={"speed": 0.0}),
        "release": scenario.release.model_copy(update={"velocity": (x, y, z)}),
    }
    job = replace(model.job, scenario=scenario.model_copy(update=calm))
    return replace(model, job=job, link=replace(model.link, velocity=velocity))


def _measure_gap(model: Model, water: Mapping[str, Any], world: str, step: float | None) -> Gap:
    link, scenario, products = model.link, model.job.scenario, water["products"]
    reader = Reader(f"Gazebo in {world}", link.added_mass, link.linear_damping, products, scenario.fluid.density)
    if water["gazebo"].solves_added_mass:
        whole = np.stack((products[0], products[1] + coriolis_products(link.added_mass)))
        reader = replace(reader, products=whole, turning=scenario.current())
    else:
        reader = replace(reader, smoothing=1.0)
    return measure_gap(reader, model.job, link, step)
