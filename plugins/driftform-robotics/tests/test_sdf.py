import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from robots import check_sdf, inertia_of, model_of, still

from driftform.motion.forces.inertia import added_mass_at, rigid_body_mass, shift_origin
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Scenario


@pytest.mark.parametrize(("name", "level"), [("random", None), ("dragged", 0.4), ("skewed", None)])
def test_ignition_accepts_files_for_fortress(name, level, jobs, export, requires_program):
    scenario = jobs[name].scenario
    fluid = scenario.fluid.model_copy(update={"water_level": level})
    afloat = replace(jobs[name], scenario=scenario.model_copy(update={"fluid": fluid}))
    folder = export("sdf", afloat, gazebo="fortress")
    for file in ("model.sdf", "world.sdf"):
        done = check_sdf(requires_program("ign"), folder / file)
        assert "Error" not in done.stderr and "Warning" not in done.stderr, done.stderr
        assert "Valid." in done.stdout


def test_added_mass_is_written_once(job, export):
    """It is in the link if the engine solves it, otherwise in the plugin: never in both, never in neither."""
    for gazebo, in_link in (("harmonic", True), ("fortress", False)):
        text = (export("sdf", job, gazebo=gazebo) / "world.sdf").read_text(encoding="utf-8")
        assert ("<fluid_added_mass>" in text) == in_link
        assert ("<xDotU>" in text) == (not in_link)


def test_fortress_gets_the_added_mass_with_the_other_sign_less_what_is_in_the_mass(job, export):
    text = (export("sdf", job, gazebo="fortress") / "model.sdf").read_text(encoding="utf-8")
    found = np.zeros((6, 6))
    for element in ET.fromstring(text).find("model/plugin"):
        if isinstance(element.tag, str) and element.tag[1:4] == "Dot":
            found["xyzkmn".index(element.tag[0]), "UVWPQR".index(element.tag[4])] = float(element.text)
    agent, inertial = job.agent, ET.fromstring(text).find("model/link/inertial")
    expected = added_mass_at(agent.coefficients, agent.mass.cog)
    moved = np.diag([float(inertial.findtext("mass")) - agent.mass.mass] * 3 + [0.0] * 3)
    moved[3:, 3:] = inertia_of(inertial.find("inertia").findtext) - agent.mass.inertia
    assert moved[0, 0] > 0
    np.testing.assert_allclose(found, moved - expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())


def test_the_release_gives_body_and_water_the_momentum_of_their_speed(jobs, export):
    job = jobs["skewed"]
    text = (export("sdf", job, step=0.002) / "push.sh").read_text(encoding="utf-8")
    force, torque = (
        np.array([float(v) for v in re.search(rf"{what}: {{x: (.*), y: (.*), z: (.*)}}", text).groups()])
        for what in ("force", "torque")
    )
    R = matrix_from_quaternion(job.scenario.release_quaternion())
    agent = job.agent
    total = shift_origin(rigid_body_mass(agent.mass), agent.mass.cog)
    total += added_mass_at(agent.coefficients, agent.mass.cog)
    gained = np.linalg.solve(total, 0.002 * np.concatenate((R.T @ force, R.T @ torque)))
    np.testing.assert_allclose(R @ gained[:3], job.scenario.release.velocity, rtol=1e-9)
    np.testing.assert_allclose(gained[3:], 0, atol=1e-8)


def test_an_agent_released_at_rest_has_no_push_script(jobs, export):
    folder = export("sdf", still(jobs["random"]))
    assert not (folder / "push.sh").exists()
    assert "push.sh" not in (folder / "world.sdf").read_text(encoding="utf-8")


def test_at_a_free_surface_spheres_displace_what_the_hull_does(jobs, export):
    """Gazebo's graded buoyancy ignores meshes; the spheres must have the hull's volume and centre, without collision."""
    job = jobs["random"]
    fluid = job.scenario.fluid.model_copy(update={"water_level": 0.4})
    afloat = replace(job, scenario=job.scenario.model_copy(update={"fluid": fluid}))
    world = ET.parse(export("sdf", afloat) / "world.sdf").getroot().find("world")
    graded = world.find("plugin[@name='gz::sim::systems::Buoyancy']/graded_buoyancy")
    assert float(graded.findtext("default_density")) == fluid.density
    assert float(graded.findtext("density_change/above_depth")) == 0.4
    volume, moment = 0.0, 0.0
    for collision in world.findall("model[@name='random']/link/collision"):
        radius = collision.findtext("geometry/sphere/radius")
        if radius is None:
            continue
        assert collision.findtext("surface/contact/collide_bitmask") == "0"
        volume += 4 / 3 * np.pi * float(radius) ** 3
        moment += 4 / 3 * np.pi * float(radius) ** 3 * float(collision.findtext("pose").split()[0])
    mass = job.agent.mass
    assert volume == pytest.approx(mass.volume, rel=1e-9)
    assert moment / volume == pytest.approx(mass.cob[0] - mass.cog[0], abs=1e-9)


@pytest.mark.parametrize("kind", ["log_law", "turbulent"])
def test_a_flow_that_is_not_uniform_becomes_its_mean_with_a_warning(kind, jobs, export):
    document = jobs["random"].scenario.model_dump() | {"flow": {"kind": kind, "speed": 0.8}}
    swirling = replace(jobs["random"], scenario=Scenario.model_validate(document))
    for format, name in (
        ("sdf", "world.sdf"),
        ("sdf", "drift.sdf"),
        ("uuv", "worlds/pipe.world"),
        ("mjcf", "agent.xml"),
    ):
        text = (export(format, swirling) / name).read_text(encoding="utf-8")
        assert f"The flow '{kind}' varies in space or time" in text
    assert "<default_current>0.8 0 0<" in (export("sdf", swirling) / "model.sdf").read_text(encoding="utf-8")


def test_the_core_is_a_frame_of_the_model(job, export):
    """Fitness refers to the core's centre, but the origin is the centre of gravity: the file must hold both."""
    model = model_of(
        export("sdf", job) / "model.sdf", ET.parse(export("sdf", job) / "model.sdf").getroot()[0].get("name")
    )
    place = [float(v) for v in model.findtext("frame[@name='core']/pose").split()[:3]]
    np.testing.assert_allclose(place, -job.agent.mass.cog, atol=1e-12)
