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
from driftform_robotics.models.ellipsoid import Ellipsoid, ellipsoid_of
from driftform_robotics.models.folder import HULL, facts_of, hull_files, piece_path, pieces_of, save
from driftform_robotics.models.link import (
    Link,
    ModelOptions,
    link_of,
    lost_by_a_uniform_current,
    lost_by_damping,
    lost_by_folding,
)
from driftform_robotics.models.meshes import Piece
from driftform_robotics.models.pipe import bore_of
from driftform_robotics.models.xml import add, document, identifier, note, number, numbers

LIFTED = 1e-9
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
        body, scenario, title = job.agent.body, job.scenario, identifier(job.name)
        pieces = pieces_of(body)
        link = link_of(job, self.options.drag_speed)
        ellipsoid = ellipsoid_of(link, scenario.fluid.density)
        beware = _beware(job, link, ellipsoid)
        agent = _agent(title, job, link, pieces, ellipsoid, self.options.step, beware)
        files = {
            "scene.xml": document(_scene(title, scenario)),
            "agent.xml": document(agent),
            **hull_files(body, job.agent.mass.cog, pieces),
        }
        return save(self.name, path, files, facts_of(link, beware))


def _beware(job: ExportJob, link: Link, ellipsoid: Ellipsoid) -> list[str]:
    scenario = job.scenario
    surge, sway = link.added_mass[0, 0] / link.mass, link.added_mass[1, 1] / link.mass
    turning = ellipsoid.turning(scenario.fluid.density)
    about = float(link.added_mass[4, 4] - link.added_mass[1, 5] ** 2 / link.added_mass[1, 1])
    found = [
        "MuJoCo leaves out the inertia of added mass: it accelerates the agent "
        f"{1 + surge:.3g} times as fast along its axis, and {1 + sway:.3g} times across.",
        f"The ellipsoid has the agent's added mass along and across; in pitch {turning:.3g} kg m2, "
        f"the agent {about:.3g}.",
        *lost_by_folding(job.agent.body),
        *lost_by_a_uniform_current(scenario),
        *lost_by_damping(link),
    ]
    if link.linear_damping.any():
        found.append("Linear damping is left out: MuJoCo's is that of a sphere, by viscosity.")
    if scenario.fluid.water_level is not None:
        found.append("MuJoCo knows no surface: the water is everywhere.")
    return found


def _agent(
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
    note(root, ["The body's origin is the centre of gravity; x is the axis, forward; z is up.", *beware])
    add(root, "compiler", angle="radian", meshdir="meshes")
    add(
        root,
        "option",
        timestep=number(step),
        integrator="implicit",
        gravity=numbers([0.0, 0.0, -fluid.gravity]),
        density=number(fluid.density),
        viscosity="0",
        wind=numbers(scenario.current()),
    )
    friction = scenario.contact.friction
    default = add(add(root, "default"), "default", class_="contact")
    # Three zeros are no friction to MuJoCo but an error of the solver: without any, contacts have one dimension.
    rubbing = {"condim": "3", "friction": f"{number(friction)} 0.005 0.0001"} if friction else {"condim": "1"}
    add(default, "geom", **rubbing)

    assets = add(root, "asset")
    meshes = [HULL, *(piece_path(index) for index in range(len(pieces)))]
    for path in meshes:
        add(assets, "mesh", name=Path(path).stem, file=Path(path).name)

    body = add(
        add(root, "worldbody"),
        "body",
        name="base_link",
        pos=numbers(link.position),
        quat=numbers(link.quaternion),
    )
    add(body, "freejoint", name="free")
    inertia = link.inertia
    add(
        body,
        "inertial",
        pos="0 0 0",
        mass=number(link.mass),
        fullinertia=numbers(
            [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))],
        ),
    )
    add(body, "site", name="core", pos=numbers(link.core), size="0.002")
    unseen = {"contype": "0", "conaffinity": "0"}
    add(body, "geom", type="mesh", mesh="hull", group="1", rgba="0.9 0.6 0.2 1", **unseen)
    for index, piece in enumerate(pieces):
        place = numbers(np.array([piece.x, 0.0, 0.0]) - cog)
        name = Path(piece_path(index)).stem
        add(body, "geom", class_="contact", type="mesh", mesh=name, pos=place, group="3")
    note(body, ["What the agent is to the water; drag: blunt, slender, angular; no lift."])
    add(
        body,
        "geom",
        name="water",
        type="ellipsoid",
        size=numbers([ellipsoid.along, ellipsoid.across, ellipsoid.across]),
        pos=numbers([ellipsoid.x, 0.0, 0.0]),
        fluidshape="ellipsoid",
        fluidcoef=numbers([ellipsoid.blunt, ellipsoid.slender, ellipsoid.angular, 0.0, 0.0]),
        group="4",
        rgba="0.3 0.5 1 0.3",
        **unseen,
    )
    note(body, ["Buoyancy: next to no mass at the centre of buoyancy, so much lighter than nothing."])
    small = LIFTED * link.mass
    lifted = add(
        body,
        "body",
        name="buoyancy",
        pos=numbers(link.buoyancy),
        gravcomp=number(fluid.density * link.volume / small),
    )
    add(
        lifted, "inertial", pos="0 0 0", mass=number(small), diaginertia=" ".join([number(1e-12 * small)] * 3)
    )
    # A body without an ellipsoid would be dragged as a box, and one so light as a box of centimetres.
    speck = numbers([1e-6] * 3)
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
        qpos=numbers(np.concatenate((link.position, link.quaternion))),
        qvel=numbers(np.concatenate((link.velocity, np.zeros(3)))),
    )
    return root


def _scene(title: str, scenario: Scenario) -> ET.Element:
    root = ET.Element("mujoco", model=f"{title} in the pipe")
    note(root, ["Begin at the keyframe 'release', which has the speed too."])
    add(root, "include", file="agent.xml")
    extent = max(
        (float(np.linalg.norm(np.subtract(s.end, s.start))) for s in scenario.pipe.segments), default=1.0
    )
    add(root, "statistic", extent=number(extent / 2))
    add(add(root, "visual"), "headlight", ambient="0.5 0.5 0.5", diffuse="0.5 0.5 0.5")
    sky = {"type": "skybox", "builtin": "gradient", "rgb1": "0.8 0.9 1", "rgb2": "0.4 0.5 0.6"}
    add(add(root, "asset"), "texture", width="64", height="64", **sky)
    world = add(root, "worldbody")
    add(world, "light", pos="0 0 5", dir="0 0 -1", directional="true")
    for index, segment in enumerate(scenario.pipe.segments):
        bore = bore_of(segment)
        pipe = add(
            world, "body", name=f"pipe_{index}", pos=numbers(bore.position), xyaxes=_axes(bore.rotation)
        )
        for plank in bore.planks():
            add(
                pipe,
                "geom",
                class_="contact",
                type="box",
                size=numbers(plank.size / 2),
                pos=numbers(plank.position),
                xyaxes=_axes(plank.rotation),
                rgba="0.6 0.8 0.9 0.15",
            )
    for name, place in scenario.targets.items():
        add(world, "site", name=f"target_{name}", pos=numbers(place), size="0.02", rgba="0.9 0.2 0.1 1")
    return root


def _axes(rotation: FloatArray) -> str:
    return numbers(rotation[:, :2].T)
