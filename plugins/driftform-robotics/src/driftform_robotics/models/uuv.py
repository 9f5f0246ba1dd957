"""A ROS package for the UUV simulator (Gazebo classic): the agent as xacro, a world with the pipe, launch files.

What that simulator does with these numbers is told by its sources, ``uuv_gazebo_plugins/src/HydrodynamicModel.cc``
(Fossen's model) and ``BuoyantObject.cc`` (buoyancy): velocities go into a frame with y to starboard and z down, in
which ``-M_A a - C_A(nu) nu + (D_1 + D_2 |nu|) nu`` is taken with added mass positive and damping negative; a is the
acceleration of the step before, smoothed. Water is where z < 0.
"""

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import ClassVar

import numpy as np

from driftform.interfaces import Exporter, ExportJob
from driftform.options import Table, option
from driftform.scenario import Scenario
from driftform.types import Body, FloatArray, WrittenFile
from driftform_robotics.models.folder import cut_hull, hull_files, model_facts, save_folder
from driftform_robotics.models.link import (
    Link,
    ModelOptions,
    make_link,
    warn_of_damping,
    warn_of_divergence,
    warn_of_flow,
    warn_of_folding,
)
from driftform_robotics.models.meshes import Piece
from driftform_robotics.models.scenery import add_light, add_pipe, add_targets, make_static
from driftform_robotics.models.urdf import add_link, package_files
from driftform_robotics.models.xml import (
    add,
    add_comment,
    format_document,
    format_fields,
    format_number,
    format_numbers,
    make_identifier,
    roll_pitch_yaw,
)

SMOOTHING = 0.3
"""Weight of the newest acceleration (``ComputeAcc`` in HydrodynamicModel.cc)."""

TO_NED = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
"""Signs of the six components in the frame of the simulator's forces (``ToNED`` in HydrodynamicModel.cc)."""

_DEPENDS = ("gazebo_ros", "robot_state_publisher", "uuv_gazebo_ros_plugins", "uuv_world_ros_plugins", "xacro")


class UuvOptions(ModelOptions):
    """Options of the exporter."""

    depth: float = option(
        20.0,
        "how far below the water's surface, which is at z = 0, the origin of the pipe's frame comes to lie, "
        "where the scenario has no surface of its own",
        "m",
        gt=0,
    )
    step: float = option(0.001, "time step of the world", "s", gt=0)


class UuvExporter(Exporter[UuvOptions]):
    """A ROS package for the UUV simulator: xacro with a Fossen model, a world with pipe and current, launch files.

    The link's origin is the centre of gravity. The simulator takes the added mass times the acceleration of the step
    before, and diverges where the added mass is 17/3 of the own mass or more: the export says so.
    """

    name = "uuv"
    suffix = "-uuv"
    Options: ClassVar[type[Table]] = UuvOptions

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write ``urdf/agent.xacro``, ``worlds/pipe.world``, ``launch/start.launch`` and ``release.launch``, and what
        makes them a package.

        Facts: as those of ``sdf``.

        Raises
        ------
        WorkFailedError
            where the body has no solid, or the files cannot be written.
        """
        body, scenario, title = job.agent.body, job.scenario, make_identifier(job.name)
        pieces = cut_hull(body)
        link = make_link(job, self.options.drag_speed)
        level = scenario.fluid.water_level
        offset = np.array([0.0, 0.0, -self.options.depth if level is None else -level])
        beware = _list_warnings(job, link, offset)
        files = {
            "launch/start.launch": format_document(_make_start_launch(title, link, offset)),
            "launch/release.launch": format_document(_make_release_launch(title, link, offset)),
            "urdf/agent.xacro": format_document(_make_robot(title, job, link, pieces, beware)),
            "worlds/pipe.world": format_document(_make_world(scenario, offset, self.options.step, beware)),
            **package_files(title, job.name, _DEPENDS),
            **hull_files(body, job.agent.mass.cog, pieces),
        }
        return save_folder(self.name, path, files, model_facts(link, beware))


def _list_warnings(job: ExportJob, link: Link, offset: FloatArray) -> list[str]:
    scenario = job.scenario
    found = warn_of_divergence(link, SMOOTHING) + warn_of_folding(job.agent.body)
    found += warn_of_flow(scenario) + warn_of_damping(link)
    top = max((max(s.start[2], s.end[2]) + s.radius for s in scenario.pipe.segments), default=-np.inf)
    if scenario.fluid.water_level is None and top + offset[2] >= 0:
        found.append(f"The pipe stands {top + offset[2]:.3g} m out of the water: set a larger depth.")
    if scenario.fluid.gravity == 0:
        found.append("The simulator does not start without gravity.")
    if _is_off_diagonal(link.quadratic_damping):
        found.append("Of the quadratic damping the simulator takes the diagonal only.")
    return found


def _is_off_diagonal(matrix: FloatArray) -> bool:
    apart = matrix - np.diag(np.diag(matrix))
    return bool(np.abs(apart).max() > 1e-12 * np.abs(matrix).max())


def _make_robot(title: str, job: ExportJob, link: Link, pieces: list[Piece], beware: list[str]) -> ET.Element:
    scenario = job.scenario
    name = "$(arg namespace)/base_link"
    root = ET.Element("robot", {"name": title, "xmlns:xacro": "http://www.ros.org/wiki/xacro"})
    add_comment(root, ["The origin is the centre of gravity; x is the axis, forward; z is up.", *beware])
    add(root, "xacro:arg", name="debug", default="0")
    add(root, "xacro:arg", name="namespace", default=title)
    add_link(root, name, link, pieces, job.agent.mass.cog, f"file://$(find {title})")
    surface = add(root, "gazebo", reference=name)
    for tag in ("mu1", "mu2"):
        add(surface, tag, format_number(scenario.contact.friction))
    plugin = add(
        add(root, "gazebo"), "plugin", name="uuv_plugin", filename="libuuv_underwater_object_ros_plugin.so"
    )
    add(plugin, "fluid_density", format_number(scenario.fluid.density))
    add(plugin, "flow_velocity_topic", "hydrodynamics/current_velocity")
    add(plugin, "debug", "$(arg debug)")
    _add_hydrodynamics(add(plugin, "link", name=name), link, job.agent.body)
    truth = add(add(root, "gazebo"), "plugin", name="pose_gt", filename="libgazebo_ros_p3d.so")
    add(truth, "robotNamespace", "$(arg namespace)")
    add(truth, "bodyName", name)
    add(truth, "topicName", "pose_gt")
    add(truth, "frameName", "world")
    add(truth, "updateRate", "50")
    return root


def _add_hydrodynamics(element: ET.Element, link: Link, body: Body) -> None:
    def turned(matrix: FloatArray) -> FloatArray:
        return np.asarray(TO_NED[:, None] * matrix * TO_NED, dtype=np.float64)

    add(element, "neutrally_buoyant", "0")
    add(element, "volume", format_number(link.volume))
    box = add(element, "box")
    for side, extent in (
        ("width", body.max_diameter),
        ("length", body.length),
        ("height", body.max_diameter),
    ):
        add(box, side, format_number(extent))
    add_comment(element, ["From the centre of gravity, z up."])
    add(element, "center_of_buoyancy", format_numbers(link.buoyancy))
    model = add(element, "hydrodynamic_model")
    add(model, "type", "fossen")
    add_comment(
        model,
        ["About the centre of gravity, y to starboard and z down: added mass positive, damping negative."],
    )
    add(model, "added_mass", _format_rows(turned(link.added_mass)))
    add(model, "linear_damping", _format_rows(-turned(link.linear_damping)))
    add(model, "quadratic_damping", format_numbers(-np.diag(link.quadratic_damping)))


def _format_rows(matrix: FloatArray) -> str:
    return "".join(f"\n            {format_numbers(row)}" for row in matrix) + "\n          "


def _make_world(scenario: Scenario, offset: FloatArray, step: float, beware: list[str]) -> ET.Element:
    root = ET.Element("sdf", version="1.5")
    world = add(root, "world", name="driftform")
    add_comment(
        world,
        [
            f"The simulator's water begins at z = 0: z here is that of the scenario {offset[2]:+g} m.",
            *warn_of_flow(scenario),
        ],
    )
    physics = add(world, "physics", name="step", default="true", type="ode")
    add(physics, "max_step_size", format_number(step))
    add(physics, "real_time_factor", "1")
    add(physics, "real_time_update_rate", format_number(1 / step))
    add(world, "gravity", format_numbers([0.0, 0.0, -scenario.fluid.gravity]))
    scene = add(world, "scene")
    add(scene, "ambient", "0.6 0.6 0.6 1")
    add(scene, "background", "0.7 0.8 0.9 1")
    add(scene, "shadows", "false")
    add_light(world)
    make_static([add_pipe(world, scenario, offset, []), add_targets(world, scenario, offset)])
    _add_current(world, scenario.current())
    return root


def _add_current(world: ET.Element, current: FloatArray) -> None:
    plugin = add(
        world,
        "plugin",
        name="underwater_current_plugin",
        filename="libuuv_underwater_current_ros_plugin.so",
    )
    add(plugin, "namespace", "hydrodynamics")
    constant = add(plugin, "constant_current")
    add(constant, "topic", "current_velocity")
    speed = float(np.linalg.norm(current))
    x, y, z = current.tolist()
    means = {
        "velocity": (speed, 0.0, max(1.0, 2 * speed)),
        "horizontal_angle": (np.arctan2(y, x), -np.pi, np.pi),
        "vertical_angle": (np.arctan2(z, np.hypot(x, y)), -np.pi, np.pi),
    }
    for tag, (mean, least, most) in means.items():
        element = add(constant, tag)
        for key, value in (("mean", mean), ("min", least), ("max", most), ("mu", 0.0), ("noiseAmp", 0.0)):
            add(element, key, format_number(value))


def _make_start_launch(title: str, link: Link, offset: FloatArray) -> ET.Element:
    root = ET.Element("launch")
    add_comment(root, [f"roslaunch {title} start.launch; then release.launch; then press play."])
    add(root, "arg", name="namespace", default=title)
    add(root, "arg", name="debug", default="0")
    add(root, "arg", name="gui", default="true")
    world = add(root, "include", file="$(find gazebo_ros)/launch/empty_world.launch")
    for name, value in (
        ("world_name", f"$(find {title})/worlds/pipe.world"),
        ("paused", "true"),
        ("use_sim_time", "true"),
        ("gui", "$(arg gui)"),
    ):
        add(world, "arg", name=name, value=value)
    group = add(root, "group", ns="$(arg namespace)")
    add(
        group,
        "param",
        name="robot_description",
        command=f"$(find xacro)/xacro '$(find {title})/urdf/agent.xacro' "
        "debug:=$(arg debug) namespace:=$(arg namespace)",
    )
    x, y, z = (format_number(value) for value in link.position + offset)
    roll, pitch, yaw = (format_number(value) for value in roll_pitch_yaw(link.rotation))
    add(
        group,
        "node",
        name="spawn",
        pkg="gazebo_ros",
        type="spawn_model",
        output="screen",
        args=f"-urdf -param robot_description -model $(arg namespace) "
        f"-x {x} -y {y} -z {z} -R {roll} -P {pitch} -Y {yaw}",
    )
    add(
        group, "node", name="robot_state_publisher", pkg="robot_state_publisher", type="robot_state_publisher"
    )
    return root


def _make_release_launch(title: str, link: Link, offset: FloatArray) -> ET.Element:
    """Neither URDF nor the spawner knows a speed: Gazebo is asked to set it, while it is paused."""
    root = ET.Element("launch")
    add(root, "arg", name="namespace", default=title)

    turn = format_fields(np.roll(link.quaternion, -1), "xyzw")
    state = (
        f"{{model_state: {{model_name: $(arg namespace), reference_frame: world, "
        f"pose: {{position: {format_fields(link.position + offset)}, orientation: {turn}}}, "
        f"twist: {{linear: {format_fields(link.velocity)}}}}}}}"
    )
    add(
        root,
        "node",
        name="release",
        pkg="rosservice",
        type="rosservice",
        args=f"call --wait /gazebo/set_model_state '{state}'",
    )
    return root
