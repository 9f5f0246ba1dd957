"""A ROS package for the UUV simulator (Gazebo classic): the agent as xacro, a world with the pipe, launch files.

The equations of that simulator are in its sources, ``uuv_gazebo_plugins/src/HydrodynamicModel.cc`` (Fossen's model) and
``BuoyantObject.cc`` (buoyancy): velocities are transformed to a frame with y to starboard and z down, in which the force
is ``-M_A a - C_A(nu) nu + (D_1 + D_2 |nu|) nu`` with positive added mass and negative damping; a is the smoothed
acceleration of the previous step. The water fills z < 0.
"""

import xml.etree.ElementTree as ET
from dataclasses import replace
from typing import ClassVar

import numpy as np

from driftform.interfaces import Table, option
from driftform.types import Body, FloatArray
from driftform.water import Scenario
from driftform_robotics.models import xml
from driftform_robotics.models.exporter import Model, ModelExporter, ModelOptions
from driftform_robotics.models.gap import Gap, measure_gap, read_link
from driftform_robotics.models.link import Link, warn_of_divergence, warn_of_flow
from driftform_robotics.models.ros2 import list_items, read_template
from driftform_robotics.models.scenery import add_pipe, add_scene, add_targets, make_static
from driftform_robotics.models.urdf import add_link
from driftform_robotics.models.xml import add, add_comment, add_maintainer, add_texts

SMOOTHING = 0.3
"""Weight of the newest acceleration (``ComputeAcc`` in HydrodynamicModel.cc)."""

TO_NED = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
"""Signs of the six components in the frame of the simulator's forces (``ToNED`` in HydrodynamicModel.cc)."""

_DEPENDS = ("gazebo_ros", "robot_state_publisher", "uuv_gazebo_ros_plugins", "uuv_world_ros_plugins", "xacro")


class UuvOptions(ModelOptions):
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

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return the launch files, the xacro, the world and the files of a ROS package, and the warnings."""
        scenario, title, link = model.job.scenario, model.title, model.link
        level = scenario.fluid.water_level
        offset = np.array([0.0, 0.0, -self.options.depth if level is None else -level])
        gap = _measure_gap(model, self.options.step)
        warnings = [gap.describe(), *_list_warnings(model, offset)]
        files = {
            "launch/start.launch": xml.format_document(_make_start_launch(title, link, offset)),
            "launch/release.launch": xml.format_document(_make_release_launch(title, link, offset)),
            "urdf/agent.xacro": xml.format_document(_make_robot(model, warnings)),
            "worlds/pipe.world": xml.format_document(_make_world(scenario, offset, gap.step)),
            **_package_files(model, warnings),
        }
        return files, warnings


def _measure_gap(model: Model, step: float | None) -> Gap:
    reader = read_link("the UUV simulator", model.link, model.job.scenario.fluid.density)
    diagonal = np.diag(np.diag(model.link.quadratic_damping))
    return measure_gap(replace(reader, quadratic=diagonal, smoothing=SMOOTHING), model.job, model.link, step)


def _list_warnings(model: Model, offset: FloatArray) -> list[str]:
    scenario = model.job.scenario
    found = [*warn_of_divergence(model.link, SMOOTHING), *model.list_warnings()]
    axes = [
        axis for placed in scenario.pipe.layout.parts for axis in placed.part.list_axes(placed.part.length)
    ]
    top = max((float((axis.points[:, 2] + axis.radii).max()) for axis in axes), default=-np.inf)
    if scenario.fluid.water_level is None and top + offset[2] >= 0:
        found.append(f"The pipe rises {top + offset[2]:.3g} m above the water: set a larger depth.")
    if scenario.fluid.gravity == 0:
        found.append("The simulator does not start without gravity.")
    damping = model.link.quadratic_damping
    if np.abs(damping - np.diag(np.diag(damping))).max() > 1e-12 * np.abs(damping).max():
        found.append("The simulator uses only the diagonal of the quadratic damping.")
    return found


def _make_robot(model: Model, warnings: list[str]) -> ET.Element:
    title, scenario = model.title, model.job.scenario
    name = "$(arg namespace)/base_link"
    root = ET.Element("robot", {"name": title, "xmlns:xacro": "http://www.ros.org/wiki/xacro"})
    add_comment(
        root, "The origin is the centre of gravity; x points forward along the axis; z points up.", *warnings
    )
    add(root, "xacro:arg", name="debug", default="0")
    add(root, "xacro:arg", name="namespace", default=title)
    add_link(root, name, model, f"file://$(find {title})")
    surface = add(root, "gazebo", reference=name)
    for tag in ("mu1", "mu2"):
        add(surface, tag, scenario.calibrated_contact().friction)
    plugin = add(
        add(root, "gazebo"), "plugin", name="uuv_plugin", filename="libuuv_underwater_object_ros_plugin.so"
    )
    topic = "hydrodynamics/current_velocity"
    add_texts(plugin, fluid_density=scenario.fluid.density, flow_velocity_topic=topic, debug="$(arg debug)")
    _add_hydrodynamics(add(plugin, "link", name=name), model.link, model.job.agent.body)
    truth = add(add(root, "gazebo"), "plugin", name="pose_gt", filename="libgazebo_ros_p3d.so")
    add_texts(truth, robotNamespace="$(arg namespace)", bodyName=name, topicName="pose_gt")
    add_texts(truth, frameName="world", updateRate="50")
    return root


def _add_hydrodynamics(element: ET.Element, link: Link, body: Body) -> None:
    def to_ned(matrix: FloatArray) -> FloatArray:
        return np.asarray(TO_NED[:, None] * matrix * TO_NED, dtype=np.float64)

    add_texts(element, neutrally_buoyant="0", volume=link.volume)
    across = body.max_diameter
    add_texts(add(element, "box"), width=across, length=body.length, height=across)
    add_comment(element, "Relative to the centre of gravity, z up.")
    add(element, "center_of_buoyancy", link.buoyancy)
    model = add(element, "hydrodynamic_model")
    add(model, "type", "fossen")
    add_comment(
        model,
        "About the centre of gravity, with y to starboard and z down: positive added mass, negative damping.",
    )
    add(model, "added_mass", _format_rows(to_ned(link.added_mass)))
    add(model, "linear_damping", _format_rows(-to_ned(link.linear_damping)))
    add(model, "quadratic_damping", -np.diag(link.quadratic_damping))


def _format_rows(matrix: FloatArray) -> str:
    return "".join(f"\n            {xml.format_numbers(row)}" for row in matrix) + "\n          "


def _make_world(scenario: Scenario, offset: FloatArray, step: float) -> ET.Element:
    root = ET.Element("sdf", version="1.5")
    world = add(root, "world", name="driftform")
    add_comment(
        world,
        f"The water's surface is at z = 0: z in this file is that of the scenario {offset[2]:+g} m.",
        *warn_of_flow(scenario),
    )
    physics = add(world, "physics", name="step", default="true", type="ode")
    add_texts(physics, max_step_size=step, real_time_factor="1", real_time_update_rate=1 / step)
    add(world, "gravity", [0.0, 0.0, -scenario.fluid.gravity])
    add_scene(world)
    make_static([add_pipe(world, scenario, offset, None), add_targets(world, scenario, offset)])
    _add_current(world, scenario.current())
    return root


def _add_current(world: ET.Element, current: FloatArray) -> None:
    plugin = add(
        world, "plugin", name="underwater_current_plugin", filename="libuuv_underwater_current_ros_plugin.so"
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
        add_texts(add(constant, tag), mean=mean, min=least, max=most, mu=0.0, noiseAmp=0.0)


def _make_start_launch(title: str, link: Link, offset: FloatArray) -> ET.Element:
    root = ET.Element("launch")
    add_comment(
        root,
        f"Run 'roslaunch {title} start.launch', then 'roslaunch {title} release.launch', then press play.",
    )
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
    xacro = f"$(find xacro)/xacro '$(find {title})/urdf/agent.xacro' debug:=$(arg debug) namespace:=$(arg namespace)"
    add(group, "param", name="robot_description", command=xacro)
    x, y, z = (xml.format_number(value) for value in link.position + offset)
    roll, pitch, yaw = (xml.format_number(value) for value in xml.roll_pitch_yaw(link.rotation))
    spawner = {"pkg": "gazebo_ros", "type": "spawn_model", "output": "screen"}
    place = f"-x {x} -y {y} -z {z} -R {roll} -P {pitch} -Y {yaw}"
    given = f"-urdf -param robot_description -model $(arg namespace) {place}"
    add(group, "node", name="spawn", **spawner, args=given)
    add(
        group, "node", name="robot_state_publisher", pkg="robot_state_publisher", type="robot_state_publisher"
    )
    return root


def _make_release_launch(title: str, link: Link, offset: FloatArray) -> ET.Element:
    """Return the launch file that sets the release velocity in the paused Gazebo: URDF and the spawner cannot."""
    root = ET.Element("launch")
    add(root, "arg", name="namespace", default=title)

    turn = xml.format_fields(np.roll(link.quaternion, -1), "xyzw")
    state = (
        f"{{model_state: {{model_name: $(arg namespace), reference_frame: world, "
        f"pose: {{position: {xml.format_fields(link.position + offset)}, orientation: {turn}}}, "
        f"twist: {{linear: {xml.format_fields(link.velocity)}}}}}}}"
    )
    call = f"call --wait /gazebo/set_model_state '{state}'"
    add(root, "node", name="release", pkg="rosservice", type="rosservice", args=call)
    return root


def _package_files(model: Model, warnings: list[str]) -> dict[str, str]:
    """Return the files that make the folder a ROS package for catkin."""
    root = ET.Element("package", format="2")
    add_texts(root, name=model.title, version="0.1.0", description=f"The agent {model.job.name} of driftform")
    add_maintainer(root)
    add_texts(root, license="MIT", buildtool_depend="catkin")
    for package in _DEPENDS:
        add(root, "exec_depend", package)
    build = f"""cmake_minimum_required(VERSION 3.0.2)
project({model.title})
find_package(catkin REQUIRED)
catkin_package()
install(DIRECTORY . DESTINATION ${{CATKIN_PACKAGE_SHARE_DESTINATION}})
"""
    readme = read_template("uuv-readme.md.in").format(
        package=model.title, agent=model.job.name, warnings=list_items(warnings)
    )
    return {"package.xml": xml.format_document(root), "CMakeLists.txt": build, "README.md": readme}
