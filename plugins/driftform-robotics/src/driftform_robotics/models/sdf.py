"""SDF for Gazebo: a model of the agent, and a world with the pipe, the water and the current.

Gazebo's equations are in its sources: gz-sim, ``src/systems/hydrodynamics`` and ``src/systems/buoyancy``; gz-physics,
``dartsim/src/AddedMassFeatures.cc``. Format: http://sdformat.org/spec.
"""

import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from driftform.agent import slice_solid
from driftform.interfaces import Table, option
from driftform.types import FloatArray
from driftform.water import Scenario
from driftform_robotics.models import scenery, xml
from driftform_robotics.models.exporter import HULL, PIPE, Model, ModelExporter, ModelOptions, piece_path
from driftform_robotics.models.gap import Gap, measure_gap, read_link
from driftform_robotics.models.gazebo_package import WORLD, gazebo_package
from driftform_robotics.models.link import make_link, warn_of_divergence, warn_of_flow
from driftform_robotics.models.meshes import obj_text
from driftform_robotics.models.pipe import make_wall
from driftform_robotics.models.xml import add, add_comment, add_texts

LINK = "base_link"
PUSH, PUSH_DRIFT = "push.sh", "push_drift.sh"

_FORCES, _RATES = "xyzkmn", "UVWPQR"
_SDF_AXES = "xyzpqr"

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

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return the worlds, the model, the mesh of the pipe and the scripts of the release, and the warnings."""
        gazebo, scenario = _GAZEBO[self.options.gazebo], model.job.scenario
        gap = _measure_gap(model, gazebo, "world.sdf", self.options.step)
        warnings = [gap.describe(), *_list_warnings(model, gazebo, PUSH)]
        alone = ET.Element("sdf", version=gazebo.sdf)
        _add_model(alone, model, gazebo, warnings)
        wall = make_wall(scenario.pipe)
        files = {
            "world.sdf": xml.format_document(_make_world(model, gazebo, gap.step, warnings)),
            "model.sdf": xml.format_document(alone),
            "model.config": xml.format_document(_make_config(model, gazebo)),
            **({} if wall is None else {PIPE: obj_text(wall.mesh)}),
        }
        if model.link.velocity.any():
            files[PUSH] = _make_push_script(model, gazebo, gap.step)
        # Nothing moves evenly with the water through a bend.
        if scenario.current().any() and _is_straight(scenario):
            drifting = _move_to_water_frame(model, self.options.drag_speed)
            gap = _measure_gap(drifting, gazebo, "drift.sdf", self.options.step)
            warnings.insert(0, gap.describe())
            adrift = [gap.describe(), *warn_of_flow(scenario), *_list_warnings(drifting, gazebo, PUSH_DRIFT)]
            world = _make_world(drifting, gazebo, gap.step, adrift, -scenario.current())
            files["drift.sdf"] = xml.format_document(world)
            if drifting.link.velocity.any():
                files[PUSH_DRIFT] = _make_push_script(drifting, gazebo, gap.step)
        shared = [*files, HULL]
        files |= gazebo_package(model, shared, gazebo.messages, gazebo.program, warnings)
        return files, warnings


def _is_straight(scenario: Scenario) -> bool:
    return scenario.pipe.is_open or scenario.pipe.straight is not None


def _move_to_water_frame(model: Model, drag_speed: float | None) -> Model:
    """Return the model in the frame of the water, where the pipe moves and the current does not: motion is the same."""
    scenario = model.job.scenario
    x, y, z = (model.link.velocity - scenario.current()).tolist()
    calm = {
        "flow": Scenario().flow.model_copy(update={"speed": 0.0}),
        "release": scenario.release.model_copy(update={"velocity": (x, y, z)}),
    }
    job = replace(model.job, scenario=scenario.model_copy(update=calm))
    return replace(model, job=job, link=make_link(job, drag_speed))


def _measure_gap(model: Model, gazebo: _Gazebo, world: str, step: float | None) -> Gap:
    link, scenario = model.link, model.job.scenario
    reader = read_link(f"Gazebo in {world}", link, scenario.fluid.density)
    if gazebo.solves_added_mass:
        reader = replace(reader, turning=scenario.current())
    else:
        reader = replace(reader, momentum=np.diag(np.diag(link.added_mass)), smoothing=1.0)
    return measure_gap(reader, model.job, link, step)


def _list_warnings(model: Model, gazebo: _Gazebo, push: str) -> list[str]:
    link, found = model.link, model.list_warnings()
    solid = sum(piece.volume for piece in model.pieces)
    if abs(solid - link.volume) > 1e-6 * link.volume:
        found.append(
            f"Gazebo computes the displaced volume from the hull, {1e6 * solid:.6g} cm3; "
            f"this agent displaces {1e6 * link.volume:.6g} cm3."
        )
    if not gazebo.solves_added_mass:
        found += warn_of_divergence(link, 1.0)
    elif model.job.scenario.current().any():
        found.append(
            "In a current Gazebo lacks the force -M_A (w x u) on an agent that rotates at w, where u is the current in "
            "body axes; gz-sim before April 2026 computes the Coriolis forces of added mass from the speed over ground."
        )
        if _is_straight(model.job.scenario):
            found[-1] += " drift.sdf is the same world in the frame of the water, where neither error occurs."
    if link.velocity.any():
        world = "world.sdf" if push == PUSH else "drift.sdf"
        found.append(
            f"Run {push} before you press play in {world}: SDF cannot hold the velocity of the release."
        )
    return found


def _make_config(model: Model, gazebo: _Gazebo) -> ET.Element:
    root = ET.Element("model")
    add_texts(root, name=model.title, version="1.0")
    add(root, "sdf", "model.sdf", version=gazebo.sdf)
    add(root, "description", f"The agent {model.job.name} of driftform")
    return root


def _add_plugin(parent: ET.Element, gazebo: _Gazebo, system: str, name: str) -> ET.Element:
    filename = f"{gazebo.system}-{system}-system"
    return add(parent, "plugin", filename=filename, name=f"{gazebo.namespace}::systems::{name}")


def _make_world(
    model: Model,
    gazebo: _Gazebo,
    step: float,
    warnings: list[str],
    passing: FloatArray | None = None,
) -> ET.Element:
    """Return a world; ``passing`` is the velocity (m/s) at which the pipe moves, ``None`` for a pipe at rest."""
    scenario = model.job.scenario
    fluid = scenario.fluid
    root = ET.Element("sdf", version=gazebo.sdf)
    if passing is not None:
        add_comment(root, *_describe_drift(model.title, passing))
    world = add(root, "world", name=WORLD)
    physics = add(world, "physics", name="step", type="ignored")
    add_texts(physics, max_step_size=step, real_time_factor="1")
    add(world, "gravity", [0.0, 0.0, -fluid.gravity])
    _add_plugin(world, gazebo, "physics", "Physics")
    _add_plugin(world, gazebo, "user-commands", "UserCommands")
    _add_plugin(world, gazebo, "scene-broadcaster", "SceneBroadcaster")
    _add_plugin(world, gazebo, "apply-link-wrench", "ApplyLinkWrench")
    buoyancy = _add_plugin(world, gazebo, "buoyancy", "Buoyancy")
    if fluid.water_level is None:
        add(buoyancy, "uniform_fluid_density", fluid.density)
    else:
        graded = add(buoyancy, "graded_buoyancy")
        add(graded, "default_density", fluid.density)
        add_texts(add(graded, "density_change"), above_depth=fluid.water_level, density="0")
    add(buoyancy, "enable", model.title)
    scenery.add_scene(world)
    pipe = scenery.add_pipe(world, scenario, np.zeros(3), PIPE)
    around = [pipe, scenery.add_targets(world, scenario, np.zeros(3))]
    if passing is None:
        scenery.make_static(around)
    else:
        _add_motion(around, passing, gazebo)
    place = xml.format_pose(model.link.position, model.link.rotation)
    _add_model(world, model, gazebo, warnings, place)
    return root


def _describe_drift(title: str, passing: FloatArray) -> list[str]:
    """The header of the world in the frame of the water."""
    velocity = xml.format_numbers(passing)
    return [
        "This world is in the frame of the water: the water is at rest, and the models 'pipe' and 'targets' move past it",
        f"at {velocity} m/s. The agent's motion relative to the pipe is that in the current.",
        f"Pose in the pipe: the pose of '{title}' less the position of the model 'pipe', which begins at 0 0 0, or less",
        f"t times {velocity} m/s at the time t; the attitude is the same. Velocity over ground: the velocity here less",
        f"{velocity} m/s. The topic /world/{WORLD}/dynamic_pose/info has the poses of all of these models.",
    ]


def _add_motion(models: list[ET.Element | None], velocity: FloatArray, gazebo: _Gazebo) -> None:
    """Make models move at a constant velocity: they are heavy, and Gazebo sets the velocity in every step."""
    for model in models:
        if model is None:
            continue
        link = model.find("link")
        assert link is not None
        add(link, "gravity", "false")
        inertial = add(link, "inertial")
        add(inertial, "mass", "1e6")
        add_texts(add(inertial, "inertia"), ixx="1e6", iyy="1e6", izz="1e6")
        control = _add_plugin(model, gazebo, "velocity-control", "VelocityControl")
        add(control, "initial_linear", velocity)


def _add_model(
    parent: ET.Element, model: Model, gazebo: _Gazebo, warnings: list[str], place: str = ""
) -> None:
    job, link = model.job, model.link
    root = add(parent, "model", name=model.title)
    add_comment(
        root, "The origin is the centre of gravity; x points forward along the axis; z points up.", *warnings
    )
    if place:
        add(root, "pose", place)
    element = add(root, "link", name=LINK)
    inertial = add(element, "inertial")
    add(inertial, "mass", link.mass)
    add_texts(add(inertial, "inertia"), **xml.format_symmetric(link.inertia, "xyz", "i"))
    if gazebo.solves_added_mass:
        added = xml.format_symmetric(link.added_mass, _SDF_AXES)
        add_texts(add(inertial, "fluid_added_mass"), **added)
    scenery.add_mesh(add(element, "visual", name="hull"), HULL)
    add_comment(
        element,
        "Each piece is convex, and its mesh is about its own centroid: Gazebo uses the position of a piece as its "
        "centre of buoyancy.",
    )
    for index, piece in enumerate(model.pieces):
        collision = add(element, "collision", name=f"piece_{index}")
        add(collision, "pose", xml.format_pose(model.axis_point(piece.x)))
        scenery.add_mesh(collision, piece_path(index))
        scenery.add_friction(collision, job.scenario.calibrated_contact().friction)
    if job.scenario.fluid.water_level is not None:
        _add_spheres(element, model)
    # After the link: a frame can be attached only to a link that is already defined.
    core = add(root, "frame", name="core", attached_to=LINK)
    add(core, "pose", xml.format_pose(link.core))
    _add_hydrodynamics(root, model, gazebo)


def _add_spheres(element: ET.Element, model: Model) -> None:
    """Append spheres: at a free surface Gazebo computes no buoyancy of meshes, and rotates no shape but spheres correctly."""
    body = model.job.agent.body
    count = int(np.clip(round(1.5 * body.length / body.max_diameter), 4, _MAX_SPHERES))
    add_comment(
        element,
        "Buoyancy at a free surface: spheres with the volumes of slices of the hull, without collision.",
    )
    for index, (x, volume, _) in enumerate(slice_solid(body.outer, count)):
        collision = add(element, "collision", name=f"slice_{index}")
        add(collision, "pose", xml.format_pose(model.axis_point(x)))
        add(add(add(collision, "geometry"), "sphere"), "radius", np.cbrt(0.75 * volume / np.pi))
        add(add(add(collision, "surface"), "contact"), "collide_bitmask", "0")


def _add_hydrodynamics(root: ET.Element, model: Model, gazebo: _Gazebo) -> None:
    link = model.link
    plugin = _add_plugin(root, gazebo, "hydrodynamics", "Hydrodynamics")
    add(plugin, "link_name", LINK)
    add_comment(plugin, "The current, world frame, m/s.")
    add(plugin, "default_current", model.job.scenario.current())
    lines = {
        f"{_FORCES[i]}{_RATES[j]}": -link.linear_damping[i, j] for i, j in _list_entries(link.linear_damping)
    } | {
        f"{_FORCES[i]}{_RATES[j]}abs{_RATES[j]}": -link.quadratic_damping[i, j]
        for i, j in _list_entries(link.quadratic_damping)
    }
    if lines:
        add_comment(plugin, "Damping, negative if it resists: force and moment per speed and rate.")
    add_texts(plugin, **lines)
    if gazebo.solves_added_mass:
        add_comment(plugin, "The added mass is in the link; here it would count twice.")
        return
    add_comment(plugin, "Added mass, negative. Gazebo computes only the Coriolis forces of its diagonal.")
    for i, j in _list_entries(link.added_mass):
        add(plugin, f"{_FORCES[i]}Dot{_RATES[j]}", -link.added_mass[i, j])


def _list_entries(matrix: FloatArray) -> list[tuple[int, int]]:
    """Return the rows and columns of the entries that are not zero to rounding."""
    found = np.argwhere(np.abs(matrix) > 1e-12 * np.abs(matrix).max())
    return [(int(i), int(j)) for i, j in found]


def _make_push_script(model: Model, gazebo: _Gazebo, step: float) -> str:
    """Return a script that gives the agent and its added mass the momentum of the release in one step."""
    force = model.link.momentum / step
    velocity = xml.format_numbers(model.link.velocity)
    return f"""#!/bin/sh
# Releases the agent at {velocity} m/s: run this while the world is paused, then press play.
# The wrench acts for the first step, {xml.format_number(step)} s: it is the momentum of the agent and its added mass over that time.
exec {gazebo.program} topic -t /world/{WORLD}/wrench -m {gazebo.messages}.EntityWrench -p '
entity: {{name: "{model.title}::{LINK}", type: LINK}}
wrench: {{
  force: {xml.format_fields(force[:3])}
  torque: {xml.format_fields(force[3:])}
}}'
"""
