"""SDF for Gazebo: a model of the agent, and a world with the pipe, the water and the current.

What Gazebo does with these numbers is told by its sources: gz-sim, ``src/systems/hydrodynamics`` and
``src/systems/buoyancy``; gz-physics, ``dartsim/src/AddedMassFeatures.cc``. Format: http://sdformat.org/spec.
"""

import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from driftform.geometry.slices import slices
from driftform.interfaces import Exporter, ExportJob
from driftform.options import Table, option
from driftform.scenario import UniformFlow
from driftform.types import FloatArray, WrittenFile
from driftform_robotics.models.folder import (
    HULL,
    PIPE,
    cut_hull,
    hull_files,
    model_facts,
    piece_path,
    save_folder,
)
from driftform_robotics.models.link import (
    Link,
    ModelOptions,
    make_link,
    warn_of_damping,
    warn_of_divergence,
    warn_of_flow,
    warn_of_folding,
)
from driftform_robotics.models.meshes import Piece, obj_text
from driftform_robotics.models.pipe import make_bore
from driftform_robotics.models.scenery import (
    add_friction,
    add_light,
    add_mesh,
    add_pipe,
    add_targets,
    make_static,
)
from driftform_robotics.models.xml import (
    add,
    add_comment,
    format_document,
    format_fields,
    format_number,
    format_numbers,
    format_pose,
    make_identifier,
)

WORLD = "driftform"
LINK = "base_link"
PUSH, PUSH_DRIFT = "push.sh", "push_drift.sh"

_FORCES, _RATES = "xyzkmn", "UVWPQR"
_SDF_AXES = "xyzpqr"

_MAX_SPHERES = 40


class SdfOptions(ModelOptions):
    """Options of the exporter."""

    gazebo: Literal["harmonic", "fortress"] = option(
        "harmonic",
        "'harmonic' and later releases read SDF 1.11; 'fortress' reads SDF 1.9 and takes the added mass "
        "times the acceleration of the step before",
    )
    step: float = option(0.001, "time step of the world", "s", gt=0)


@dataclass(frozen=True)
class _Gazebo:
    """What a release of Gazebo calls its own, and whether it solves the added mass together with the mass."""

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


class SdfExporter(Exporter[SdfOptions]):
    """A model for Gazebo and a world around it: pipe, water, current and buoyancy, ready for `gz sim world.sdf`.

    In a current there is `drift.sdf` besides, where the pipe moves past water at rest: what Gazebo does with added
    mass is exact there, and is not in a current. The link's origin is the centre of gravity. The added mass is
    `<fluid_added_mass>`, which DART, Gazebo's usual engine, solves together with the mass. The hull collides, and
    displaces water, as closed convex pieces.
    """

    name = "sdf"
    suffix = "-sdf"
    Options: ClassVar[type[Table]] = SdfOptions

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write ``world.sdf``, ``model.sdf`` with its ``model.config``, and meshes.

        There is ``push.sh`` too for an agent that is released with a speed, and in a current ``drift.sdf``: the
        same world in the frame of the water, with a pipe that moves.

        Facts: ``mass_kg``, ``cog_mm`` and ``cob_mm`` along the axis from the core's centre, ``volume_mm3``,
        ``added_over_own_mass``, and what to ``beware`` of, if anything.

        Raises
        ------
        WorkFailedError
            where the body has no solid, or the files cannot be written.
        """
        body, scenario = job.agent.body, job.scenario
        gazebo, title = _GAZEBO[self.options.gazebo], make_identifier(job.name)
        pieces = cut_hull(body)
        link = make_link(job, self.options.drag_speed)
        beware = _list_warnings(job, link, pieces, gazebo, PUSH)

        alone = ET.Element("sdf", version=gazebo.sdf)
        _add_model(alone, title, job, link, pieces, gazebo, beware)
        pipes = [make_bore(segment).make_mesh() for segment in scenario.pipe.segments]
        step = self.options.step
        files = {
            "world.sdf": format_document(_make_world(job, link, pieces, gazebo, step, beware)),
            "model.sdf": format_document(alone),
            "model.config": format_document(_make_config(title, job.name, gazebo)),
            **hull_files(body, job.agent.mass.cog, pieces),
            **({PIPE: obj_text(pipes[0])} if pipes else {}),
        }
        if link.velocity.any():
            files[PUSH] = _make_push_script(title, link, gazebo, step)
        if scenario.current().any():
            drifting = _move_to_water_frame(job)
            adrift = make_link(drifting, self.options.drag_speed)
            told = warn_of_flow(scenario) + _list_warnings(drifting, adrift, pieces, gazebo, PUSH_DRIFT)
            world = _make_world(drifting, adrift, pieces, gazebo, step, told, -scenario.current())
            files["drift.sdf"] = format_document(world)
            if adrift.velocity.any():
                files[PUSH_DRIFT] = _make_push_script(title, adrift, gazebo, step)
        return save_folder(self.name, path, files, model_facts(link, beware))


def _move_to_water_frame(job: ExportJob) -> ExportJob:
    """The same in the frame of the water, where the pipe moves and the current does not: motion is the same there."""
    scenario = job.scenario
    released = make_link(job).velocity - scenario.current()
    x, y, z = released.tolist()
    calm = {
        "flow": UniformFlow(speed=0.0),
        "release": scenario.release.model_copy(update={"velocity": (x, y, z)}),
    }
    return replace(job, scenario=scenario.model_copy(update=calm))


def _list_warnings(job: ExportJob, link: Link, pieces: list[Piece], gazebo: _Gazebo, push: str) -> list[str]:
    scenario = job.scenario
    found = warn_of_folding(job.agent.body) + warn_of_flow(scenario) + warn_of_damping(link)
    solid = sum(piece.volume for piece in pieces)
    if abs(solid - link.volume) > 1e-6 * link.volume:
        found.append(
            f"Gazebo takes the displaced volume from the hull, {1e6 * solid:.6g} cm3; "
            f"this agent displaces {1e6 * link.volume:.6g} cm3."
        )
    if not gazebo.solves_added_mass:
        found += warn_of_divergence(link, 1.0)
    elif scenario.current().any():
        found.append(
            "In a current Gazebo lacks the force -M_A (w x u) on an agent that turns, u being the current in body "
            "axes; gz-sim before April 2026 takes the Coriolis forces of added mass with the speed over ground. "
            "drift.sdf is the same world seen from the water, where neither matters."
        )
    if link.velocity.any():
        found.append(f"Run {push} before you press play: SDF has no place for the speed of the release.")
    return found


def _make_config(title: str, name: str, gazebo: _Gazebo) -> ET.Element:
    root = ET.Element("model")
    add(root, "name", title)
    add(root, "version", "1.0")
    add(root, "sdf", "model.sdf", version=gazebo.sdf)
    add(root, "description", f"The agent {name} of driftform")
    return root


def _add_plugin(parent: ET.Element, gazebo: _Gazebo, system: str, name: str) -> ET.Element:
    return add(
        parent,
        "plugin",
        filename=f"{gazebo.system}-{system}-system",
        name=f"{gazebo.namespace}::systems::{name}",
    )


def _make_world(
    job: ExportJob,
    link: Link,
    pieces: list[Piece],
    gazebo: _Gazebo,
    step: float,
    beware: list[str],
    passing: FloatArray | None = None,
) -> ET.Element:
    """A world; ``passing`` is the velocity (m/s) with which the pipe moves past the water, none where it stands."""
    scenario = job.scenario
    fluid = scenario.fluid
    root = ET.Element("sdf", version=gazebo.sdf)
    world = add(root, "world", name=WORLD)
    physics = add(world, "physics", name="step", type="ignored")
    add(physics, "max_step_size", format_number(step))
    add(physics, "real_time_factor", "1")
    add(world, "gravity", format_numbers([0.0, 0.0, -fluid.gravity]))
    _add_plugin(world, gazebo, "physics", "Physics")
    _add_plugin(world, gazebo, "user-commands", "UserCommands")
    _add_plugin(world, gazebo, "scene-broadcaster", "SceneBroadcaster")
    _add_plugin(world, gazebo, "apply-link-wrench", "ApplyLinkWrench")
    title = make_identifier(job.name)
    buoyancy = _add_plugin(world, gazebo, "buoyancy", "Buoyancy")
    if fluid.water_level is None:
        add(buoyancy, "uniform_fluid_density", format_number(fluid.density))
    else:
        graded = add(buoyancy, "graded_buoyancy")
        add(graded, "default_density", format_number(fluid.density))
        change = add(graded, "density_change")
        add(change, "above_depth", format_number(fluid.water_level))
        add(change, "density", "0")
    add(buoyancy, "enable", title)
    scene = add(world, "scene")
    add(scene, "ambient", "0.6 0.6 0.6 1")
    add(scene, "background", "0.7 0.8 0.9 1")
    add(scene, "shadows", "false")
    add_light(world)
    pipe = add_pipe(world, scenario, np.zeros(3), [PIPE] * len(scenario.pipe.segments))
    around = [pipe, add_targets(world, scenario, np.zeros(3))]
    if passing is None:
        make_static(around)
    else:
        _add_motion(around, passing, gazebo)
    _add_model(world, title, job, link, pieces, gazebo, beware, format_pose(link.position, link.rotation))
    return root


def _add_motion(models: list[ET.Element | None], velocity: FloatArray, gazebo: _Gazebo) -> None:
    """Make models move with a velocity that nothing changes: they are heavy, and Gazebo sets it in every step."""
    for model in models:
        if model is None:
            continue
        link = model.find("link")
        assert link is not None
        add(link, "gravity", "false")
        inertial = add(link, "inertial")
        add(inertial, "mass", "1e6")
        inertia = add(inertial, "inertia")
        for axis in "xyz":
            add(inertia, f"i{axis}{axis}", "1e6")
        control = _add_plugin(model, gazebo, "velocity-control", "VelocityControl")
        add(control, "initial_linear", format_numbers(velocity))


def _add_model(
    parent: ET.Element,
    title: str,
    job: ExportJob,
    link: Link,
    pieces: list[Piece],
    gazebo: _Gazebo,
    beware: list[str],
    place: str = "",
) -> None:
    scenario, cog = job.scenario, job.agent.mass.cog
    model = add(parent, "model", name=title)
    add_comment(model, ["The origin is the centre of gravity; x is the axis, forward; z is up.", *beware])
    if place:
        add(model, "pose", place)
    element = add(model, "link", name=LINK)
    inertial = add(element, "inertial")
    add(inertial, "mass", format_number(link.mass))
    inertia = add(inertial, "inertia")
    for i, j in combinations_with_replacement(range(3), 2):
        add(inertia, f"i{'xyz'[i]}{'xyz'[j]}", format_number(link.inertia[i, j]))
    if gazebo.solves_added_mass:
        added = add(inertial, "fluid_added_mass")
        for i, j in combinations_with_replacement(range(6), 2):
            add(added, f"{_SDF_AXES[i]}{_SDF_AXES[j]}", format_number(link.added_mass[i, j]))
    add_mesh(add(element, "visual", name="hull"), HULL)
    add_comment(
        element,
        [
            "Each piece is convex, and its mesh is about its own centroid: Gazebo takes a piece's place for the "
            "centre of its buoyancy."
        ],
    )
    for index, piece in enumerate(pieces):
        collision = add(element, "collision", name=f"piece_{index}")
        add(collision, "pose", format_pose(np.array([piece.x, 0.0, 0.0]) - cog))
        add_mesh(collision, piece_path(index))
        add_friction(collision, scenario.contact.friction)
    if scenario.fluid.water_level is not None:
        _add_spheres(element, job)
    # After the link, because a frame may be attached only to what is known.
    core = add(model, "frame", name="core", attached_to=LINK)
    add(core, "pose", format_pose(link.core))
    _add_hydrodynamics(model, job, link, gazebo)


def _add_spheres(element: ET.Element, job: ExportJob) -> None:
    """At a free surface Gazebo takes no mesh for buoyancy, and turns no shape but a sphere with the body."""
    body, cog = job.agent.body, job.agent.mass.cog
    count = int(np.clip(round(1.5 * body.length / body.max_diameter), 4, _MAX_SPHERES))
    add_comment(
        element, ["Buoyancy at a free surface: spheres of the volume of slices, which nothing collides with."]
    )
    for index, (x, volume, _) in enumerate(slices(body.outer, count)):
        collision = add(element, "collision", name=f"slice_{index}")
        add(collision, "pose", format_pose(np.array([x, 0.0, 0.0]) - cog))
        add(
            add(add(collision, "geometry"), "sphere"), "radius", format_number(np.cbrt(0.75 * volume / np.pi))
        )
        add(add(add(collision, "surface"), "contact"), "collide_bitmask", "0")


def _add_hydrodynamics(model: ET.Element, job: ExportJob, link: Link, gazebo: _Gazebo) -> None:
    plugin = _add_plugin(model, gazebo, "hydrodynamics", "Hydrodynamics")
    add(plugin, "link_name", LINK)
    add_comment(plugin, ["The current, world frame, m/s."])
    add(plugin, "default_current", format_numbers(job.scenario.current()))
    lines = {
        f"{_FORCES[i]}{_RATES[j]}": -link.linear_damping[i, j] for i, j in _list_entries(link.linear_damping)
    } | {
        f"{_FORCES[i]}{_RATES[j]}abs{_RATES[j]}": -link.quadratic_damping[i, j]
        for i, j in _list_entries(link.quadratic_damping)
    }
    if lines:
        add_comment(plugin, ["Damping, negative where it resists: force and moment by speed and rate."])
    for tag, value in lines.items():
        add(plugin, tag, format_number(value))
    if gazebo.solves_added_mass:
        add_comment(plugin, ["The added mass is the link's: here it would count twice."])
        return
    add_comment(plugin, ["Added mass, negative; of its Coriolis forces Gazebo has those of the diagonal."])
    for i, j in _list_entries(link.added_mass):
        add(plugin, f"{_FORCES[i]}Dot{_RATES[j]}", format_number(-link.added_mass[i, j]))


def _list_entries(matrix: FloatArray) -> list[tuple[int, int]]:
    """Rows and columns of what is not zero, but for rounding."""
    found = np.argwhere(np.abs(matrix) > 1e-12 * np.abs(matrix).max())
    return [(int(i), int(j)) for i, j in found]


def _make_push_script(title: str, link: Link, gazebo: _Gazebo, step: float) -> str:
    """A script that gives the agent, and the water it moves, the momentum of the release within one step."""
    force = link.momentum / step

    speed = format_numbers(link.velocity)
    return f"""#!/bin/sh
# Releases the agent at {speed} m/s: run it while the world is paused, then press play.
# The wrench acts for the first step of {format_number(step)} s, and is the momentum of the agent and its added mass over that.
exec {gazebo.program} topic -t /world/{WORLD}/wrench -m {gazebo.messages}.EntityWrench -p '
entity: {{name: "{title}::{LINK}", type: LINK}}
wrench: {{
  force: {format_fields(force[:3])}
  torque: {format_fields(force[3:])}
}}'
"""
