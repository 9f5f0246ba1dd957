"""MJCF for MuJoCo: the agent in water, and a scene with the pipe.

Format: https://mujoco.readthedocs.io, "XML reference". :mod:`driftform_robotics.models.ellipsoid` describes how MuJoCo
computes the forces of the water.
"""

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from driftform.interfaces import Table
from driftform.water import Scenario
from driftform_robotics.models.ellipsoid import Ellipsoid, fit_ellipsoid
from driftform_robotics.models.exporter import HULL, PIPE, Model, ModelExporter, ModelOptions, piece_path
from driftform_robotics.models.gap import COMMON_STEP, measure_gap
from driftform_robotics.models.meshes import obj_text
from driftform_robotics.models.mujoco_path import REACH, compare_paths, read_mujoco
from driftform_robotics.models.pipe import Wall, list_bores, make_wall
from driftform_robotics.models.xml import add, add_comment, format_document

_WALL = "wall"

BUOYANT_MASS = 1e-9
"""Mass of the small body on which buoyancy acts, relative to the agent's."""


class MjcfExporter(ModelExporter[ModelOptions]):
    """A model for MuJoCo: inertia, exact buoyancy, and an ellipsoid with the agent's added mass along and across.

    `scene.xml` holds the pipe and includes `agent.xml`. MuJoCo models the Coriolis forces of added mass, Munk's moment
    among them, but not its inertia: agents accelerate as if they moved no water. A warning states how far the path is from
    the true one, and whether a sinking agent rises. The body frame and the free joint are at the centre of gravity.
    """

    name = "mjcf"
    suffix = "-mjcf"
    Options: ClassVar[type[Table]] = ModelOptions

    def make_files(self, model: Model) -> tuple[dict[str, str], list[str]]:
        """Return ``scene.xml`` and ``agent.xml``, and the warnings."""
        ellipsoid = fit_ellipsoid(model.link, model.job.scenario.fluid.density)
        step = self.options.step or COMMON_STEP
        gap = measure_gap(read_mujoco(model.job, model.link), model.job, model.link, step)
        warnings = _list_warnings(model, ellipsoid)
        warnings.insert(1, gap.describe())
        agent = _make_agent(model, ellipsoid, step, warnings)
        pipe = model.job.scenario.pipe
        wall = make_wall(pipe) if pipe.straight is None else None
        scene = _make_scene(model.title, model.job.scenario, wall)
        files = {"scene.xml": format_document(scene), "agent.xml": format_document(agent)}
        return files | ({} if wall is None else {PIPE: obj_text(wall.mesh)}), warnings


def _list_warnings(model: Model, ellipsoid: Ellipsoid) -> list[str]:
    link, scenario = model.link, model.job.scenario
    fluid = scenario.fluid
    reach = REACH if scenario.pipe.is_open else scenario.pipe.layout.narrowest
    surge, sway = link.added_mass[0, 0] / link.mass, link.added_mass[1, 1] / link.mass
    pitch = float(link.added_mass[4, 4] - link.added_mass[1, 5] ** 2 / link.added_mass[1, 1])
    found = [
        compare_paths(model.job, link, reach).describe(),
        "MuJoCo ignores the inertia of added mass: it accelerates the agent "
        f"{1 + surge:.3g} times as fast along its axis, and {1 + sway:.3g} times as fast across it.",
        "The ellipsoid has the agent's added mass along and across its axis; in pitch it has "
        f"{ellipsoid.added_inertia(fluid.density):.3g} kg m2, and the agent {pitch:.3g} kg m2.",
        *model.list_warnings(),
    ]
    if link.linear_damping.any():
        found.append(
            "Linear damping is left out: MuJoCo's linear damping is that of a sphere, from viscosity."
        )
    if fluid.water_level is not None:
        found.append("MuJoCo has no water surface: the water is everywhere.")
    return found


def _make_agent(model: Model, ellipsoid: Ellipsoid, step: float, warnings: list[str]) -> ET.Element:
    link, pieces, scenario = model.link, model.pieces, model.job.scenario
    fluid = scenario.fluid
    root = ET.Element("mujoco", model=model.title)
    add_comment(
        root,
        "The body's origin is the centre of gravity; x points forward along the axis; z points up.",
        *warnings,
    )
    add(root, "compiler", angle="radian", meshdir="meshes")
    down = [0.0, 0.0, -fluid.gravity]
    medium: dict[str, Any] = {"density": fluid.density, "viscosity": "0", "wind": scenario.current()}
    add(root, "option", timestep=step, integrator="implicit", gravity=down, **medium)
    friction = scenario.calibrated_contact().friction
    default = add(add(root, "default"), "default", class_="contact")
    # MuJoCo's solver fails for three zero coefficients: contacts without friction have one dimension instead.
    rubbing: dict[str, Any] = (
        {"condim": "3", "friction": [friction, 0.005, 0.0001]} if friction else {"condim": "1"}
    )
    add(default, "geom", **rubbing)

    assets = add(root, "asset")
    meshes = [HULL, *(piece_path(index) for index in range(len(pieces)))]
    for path in meshes:
        add(assets, "mesh", name=Path(path).stem, file=Path(path).name)

    body = add(add(root, "worldbody"), "body", name="base_link", pos=link.position, quat=link.quaternion)
    add(body, "freejoint", name="free")
    inertia = [link.inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    add(body, "inertial", pos="0 0 0", mass=link.mass, fullinertia=inertia)
    add(body, "site", name="core", pos=link.core, size="0.002")
    unseen = {"contype": "0", "conaffinity": "0"}
    add(body, "geom", type="mesh", mesh="hull", group="1", rgba="0.9 0.6 0.2 1", **unseen)
    for index, piece in enumerate(pieces):
        place, name = model.axis_point(piece.x), Path(piece_path(index)).stem
        add(body, "geom", class_="contact", type="mesh", mesh=name, pos=place, group="3")
    add_comment(
        body, "The ellipsoid for the forces of the water. Drag: blunt, slender, angular. Without lift."
    )
    size = [ellipsoid.along, ellipsoid.across, ellipsoid.across]
    drag = [ellipsoid.blunt, ellipsoid.slender, ellipsoid.angular, 0.0, 0.0]
    water: dict[str, Any] = {"pos": [ellipsoid.x, 0.0, 0.0], "fluidshape": "ellipsoid", "fluidcoef": drag}
    look = {"group": "4", "rgba": "0.3 0.5 1 0.3"}
    add(body, "geom", name="water", type="ellipsoid", size=size, **water, **look, **unseen)
    add_comment(
        body, "Buoyancy: a body of negligible mass at the centre of buoyancy, lifted by gravity compensation."
    )
    small = BUOYANT_MASS * link.mass
    lifted = add(
        body, "body", name="buoyancy", pos=link.buoyancy, gravcomp=fluid.density * link.volume / small
    )
    add(lifted, "inertial", pos="0 0 0", mass=small, diaginertia=[1e-12 * small] * 3)
    # For a body without an ellipsoid MuJoCo would compute the drag of a box, with edges of centimetres at this mass.
    speck: dict[str, Any] = {
        "type": "ellipsoid",
        "size": [1e-6] * 3,
        "fluidshape": "ellipsoid",
        "fluidcoef": "0 0 0 0 0",
    }
    add(lifted, "geom", **speck, group="4", **unseen)
    pose, velocity = (*link.position, *link.quaternion), (*link.velocity, 0.0, 0.0, 0.0)
    add(add(root, "keyframe"), "key", name="release", qpos=pose, qvel=velocity)
    return root


def _make_scene(title: str, scenario: Scenario, wall: Wall | None) -> ET.Element:
    """Return the scene; the planks of a pipe with parts are hidden, and its ``wall`` is displayed in their place."""
    root = ET.Element("mujoco", model=f"{title} in the pipe")
    add_comment(root, "Start at the keyframe 'release', which also sets the velocity.")
    add(root, "include", file="agent.xml")
    bores = list_bores(scenario.pipe)
    extent = max((bore.length for bore in bores), default=1.0)
    if len(bores) > 1:
        extent = float(np.ptp([bore.position for bore in bores], axis=0).max())
    add(root, "statistic", extent=extent / 2)
    add(add(root, "visual"), "headlight", ambient="0.5 0.5 0.5", diffuse="0.5 0.5 0.5")
    sky = {"type": "skybox", "builtin": "gradient", "rgb1": "0.8 0.9 1", "rgb2": "0.4 0.5 0.6"}
    assets = add(root, "asset")
    add(assets, "texture", width="64", height="64", **sky)
    world = add(root, "worldbody")
    add(world, "light", pos="0 0 5", dir="0 0 -1", directional="true")
    glass = {"rgba": "0.6 0.8 0.9 0.15"}
    if wall is not None:
        add(assets, "mesh", name=_WALL, file=Path(PIPE).name)
        seen = {"contype": "0", "conaffinity": "0", "group": "1"}
        add_comment(
            world,
            "The wall is for display; its boxes in group 3 collide. A mesh would collide as its convex hull, which is solid.",
        )
        add(world, "geom", name=_WALL, type="mesh", mesh=_WALL, **seen, **glass)
        glass["group"] = "3"
    for index, bore in enumerate(bores):
        pipe = add(world, "body", name=f"pipe_{index}", pos=bore.position, xyaxes=bore.rotation[:, :2].T)
        for plank in bore.make_planks():
            box = {"size": plank.size / 2, "pos": plank.position, "xyaxes": plank.rotation[:, :2].T}
            add(pipe, "geom", class_="contact", type="box", **box, **glass)
    for name, place in scenario.target_points().items():
        add(world, "site", name=f"target_{name}", pos=place, size="0.02", rgba="0.9 0.2 0.1 1")
    return root
