"""MJCF for MuJoCo: the agent in its water, and a scene with the pipe around it.

Format: https://mujoco.readthedocs.io, "XML reference"; for what MuJoCo does with it see
:mod:`driftform_robotics.models.ellipsoid`.
"""

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import ClassVar

import numpy as np

from driftform.interfaces import Exporter, ExportJob
from driftform.options import Table, option
from driftform.scenario import Scenario
from driftform.types import FloatArray, WrittenFile
from driftform_robotics.models.ellipsoid import Ellipsoid, fit_ellipsoid
from driftform_robotics.models.folder import HULL, cut_hull, hull_files, model_facts, piece_path, save_folder
from driftform_robotics.models.link import (
    Link,
    ModelOptions,
    make_link,
    warn_of_damping,
    warn_of_flow,
    warn_of_folding,
)
from driftform_robotics.models.meshes import Piece
from driftform_robotics.models.pipe import make_bore
from driftform_robotics.models.xml import (
    add,
    add_comment,
    format_document,
    format_number,
    format_numbers,
    make_identifier,
)

BUOYANT_MASS = 1e-9
"""Mass over the agent's of the little body that buoyancy lifts."""


class MjcfOptions(ModelOptions):
    """Options of the exporter."""

    step: float = option(0.001, "time step", "s", gt=0)


class MjcfExporter(Exporter[MjcfOptions]):
    """A model for MuJoCo: inertia, exact buoyancy, and the ellipsoid with the agent's added mass along and across.

    MuJoCo has the Coriolis forces of added mass, Munk's moment among them, and leaves out its inertia: agents
    accelerate there as if no water had to be moved. Body frame and free joint are at the centre of gravity.
    """

    name = "mjcf"
    suffix = "-mjcf"
    Options: ClassVar[type[Table]] = MjcfOptions

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write ``scene.xml`` with the pipe, ``agent.xml``, which it includes, and meshes.

        Facts: as those of ``sdf``.

        Raises
        ------
        WorkFailedError
            where the body has no solid, or the files cannot be written.
        """
        body, scenario, title = job.agent.body, job.scenario, make_identifier(job.name)
        pieces = cut_hull(body)
        link = make_link(job, self.options.drag_speed)
        ellipsoid = fit_ellipsoid(link, scenario.fluid.density)
        beware = _list_warnings(job, link, ellipsoid)
        agent = _make_agent(title, job, link, pieces, ellipsoid, self.options.step, beware)
        files = {
            "scene.xml": format_document(_make_scene(title, scenario)),
            "agent.xml": format_document(agent),
            **hull_files(body, job.agent.mass.cog, pieces),
        }
        return save_folder(self.name, path, files, model_facts(link, beware))


def _list_warnings(job: ExportJob, link: Link, ellipsoid: Ellipsoid) -> list[str]:
    scenario = job.scenario
    surge, sway = link.added_mass[0, 0] / link.mass, link.added_mass[1, 1] / link.mass
    turning = ellipsoid.added_inertia(scenario.fluid.density)
    about = float(link.added_mass[4, 4] - link.added_mass[1, 5] ** 2 / link.added_mass[1, 1])
    found = [
        "MuJoCo leaves out the inertia of added mass: it accelerates the agent "
        f"{1 + surge:.3g} times as fast along its axis, and {1 + sway:.3g} times across.",
        f"The ellipsoid has the agent's added mass along and across; in pitch {turning:.3g} kg m2, "
        f"the agent {about:.3g}.",
        *warn_of_folding(job.agent.body),
        *warn_of_flow(scenario),
        *warn_of_damping(link),
    ]
    if link.linear_damping.any():
        found.append("Linear damping is left out: MuJoCo's is that of a sphere, by viscosity.")
    if scenario.fluid.water_level is not None:
        found.append("MuJoCo knows no surface: the water is everywhere.")
    return found


def _make_agent(
    title: str,
    job: ExportJob,
    link: Link,
    pieces: list[Piece],
    ellipsoid: Ellipsoid,
    step: float,
    beware: list[str],
) -> ET.Element:
    scenario, cog = job.scenario, job.agent.mass.cog
    fluid = scenario.fluid
    root = ET.Element("mujoco", model=title)
    add_comment(
        root, ["The body's origin is the centre of gravity; x is the axis, forward; z is up.", *beware]
    )
    add(root, "compiler", angle="radian", meshdir="meshes")
    add(
        root,
        "option",
        timestep=format_number(step),
        integrator="implicit",
        gravity=format_numbers([0.0, 0.0, -fluid.gravity]),
        density=format_number(fluid.density),
        viscosity="0",
        wind=format_numbers(scenario.current()),
    )
    friction = scenario.contact.friction
    default = add(add(root, "default"), "default", class_="contact")
    # Three zeros are no friction to MuJoCo but an error of the solver: without any, contacts have one dimension.
    rubbing = (
        {"condim": "3", "friction": f"{format_number(friction)} 0.005 0.0001"}
        if friction
        else {"condim": "1"}
    )
    add(default, "geom", **rubbing)

    assets = add(root, "asset")
    meshes = [HULL, *(piece_path(index) for index in range(len(pieces)))]
    for path in meshes:
        add(assets, "mesh", name=Path(path).stem, file=Path(path).name)

    body = add(
        add(root, "worldbody"),
        "body",
        name="base_link",
        pos=format_numbers(link.position),
        quat=format_numbers(link.quaternion),
    )
    add(body, "freejoint", name="free")
    inertia = link.inertia
    add(
        body,
        "inertial",
        pos="0 0 0",
        mass=format_number(link.mass),
        fullinertia=format_numbers(
            [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))],
        ),
    )
    add(body, "site", name="core", pos=format_numbers(link.core), size="0.002")
    unseen = {"contype": "0", "conaffinity": "0"}
    add(body, "geom", type="mesh", mesh="hull", group="1", rgba="0.9 0.6 0.2 1", **unseen)
    for index, piece in enumerate(pieces):
        place = format_numbers(np.array([piece.x, 0.0, 0.0]) - cog)
        name = Path(piece_path(index)).stem
        add(body, "geom", class_="contact", type="mesh", mesh=name, pos=place, group="3")
    add_comment(body, ["What the agent is to the water; drag: blunt, slender, angular; no lift."])
    add(
        body,
        "geom",
        name="water",
        type="ellipsoid",
        size=format_numbers([ellipsoid.along, ellipsoid.across, ellipsoid.across]),
        pos=format_numbers([ellipsoid.x, 0.0, 0.0]),
        fluidshape="ellipsoid",
        fluidcoef=format_numbers([ellipsoid.blunt, ellipsoid.slender, ellipsoid.angular, 0.0, 0.0]),
        group="4",
        rgba="0.3 0.5 1 0.3",
        **unseen,
    )
    add_comment(body, ["Buoyancy: next to no mass at the centre of buoyancy, so much lighter than nothing."])
    small = BUOYANT_MASS * link.mass
    lifted = add(
        body,
        "body",
        name="buoyancy",
        pos=format_numbers(link.buoyancy),
        gravcomp=format_number(fluid.density * link.volume / small),
    )
    add(
        lifted,
        "inertial",
        pos="0 0 0",
        mass=format_number(small),
        diaginertia=" ".join([format_number(1e-12 * small)] * 3),
    )
    # A body without an ellipsoid would be dragged as a box, and one so light as a box of centimetres.
    speck = format_numbers([1e-6] * 3)
    add(
        lifted,
        "geom",
        type="ellipsoid",
        size=speck,
        fluidshape="ellipsoid",
        fluidcoef="0 0 0 0 0",
        group="4",
        **unseen,
    )
    keys = add(root, "keyframe")
    add(
        keys,
        "key",
        name="release",
        qpos=format_numbers(np.concatenate((link.position, link.quaternion))),
        qvel=format_numbers(np.concatenate((link.velocity, np.zeros(3)))),
    )
    return root


def _make_scene(title: str, scenario: Scenario) -> ET.Element:
    root = ET.Element("mujoco", model=f"{title} in the pipe")
    add_comment(root, ["Begin at the keyframe 'release', which has the speed too."])
    add(root, "include", file="agent.xml")
    extent = max(
        (float(np.linalg.norm(np.subtract(s.end, s.start))) for s in scenario.pipe.segments), default=1.0
    )
    add(root, "statistic", extent=format_number(extent / 2))
    add(add(root, "visual"), "headlight", ambient="0.5 0.5 0.5", diffuse="0.5 0.5 0.5")
    sky = {"type": "skybox", "builtin": "gradient", "rgb1": "0.8 0.9 1", "rgb2": "0.4 0.5 0.6"}
    add(add(root, "asset"), "texture", width="64", height="64", **sky)
    world = add(root, "worldbody")
    add(world, "light", pos="0 0 5", dir="0 0 -1", directional="true")
    for index, segment in enumerate(scenario.pipe.segments):
        bore = make_bore(segment)
        pipe = add(
            world,
            "body",
            name=f"pipe_{index}",
            pos=format_numbers(bore.position),
            xyaxes=_format_axes(bore.rotation),
        )
        for plank in bore.make_planks():
            add(
                pipe,
                "geom",
                class_="contact",
                type="box",
                size=format_numbers(plank.size / 2),
                pos=format_numbers(plank.position),
                xyaxes=_format_axes(plank.rotation),
                rgba="0.6 0.8 0.9 0.15",
            )
    for name, place in scenario.targets.items():
        add(
            world, "site", name=f"target_{name}", pos=format_numbers(place), size="0.02", rgba="0.9 0.2 0.1 1"
        )
    return root


def _format_axes(rotation: FloatArray) -> str:
    return format_numbers(rotation[:, :2].T)
