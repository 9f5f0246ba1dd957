"""DART, the engine of Gazebo, with the numbers of the SDF file, against our own flights."""

import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from robots import inertia_of
from scipy.spatial.transform import Rotation

from driftform.interfaces import ExportJob
from driftform.motion.path.interpolation import interpolate_positions
from driftform.types import Coefficients
from driftform.water import Fluid, Scenario
from driftform.water.flow import UniformFlow
from driftform.water.scenario import FlightLimits, Release
from driftform_robotics.models.gap import fly_own, fly_reader, read_link
from driftform_robotics.models.link import make_link

if sys.platform == "win32":
    pytest.skip("DART has no wheel for Windows", allow_module_level=True)
dart = import_module("dartpy")


def spatial(inertial):
    """Mass and added mass as DART has them: rotations first (``AddedMassFeatures::SetLinkAddedMass``)."""
    matrix = np.zeros((6, 6))
    for element in inertial.find("fluid_added_mass"):
        i, j = ("xyzpqr".index(c) for c in element.tag)
        matrix[i, j] = matrix[j, i] = float(element.text)
    matrix[:3, :3] += float(inertial.findtext("mass")) * np.eye(3)
    matrix[3:, 3:] += inertia_of(inertial.find("inertia").findtext)
    order = [3, 4, 5, 0, 1, 2]
    return matrix[np.ix_(order, order)]


def flight_by_dart(job, folder, step, frame="core"):
    """Times and places of the core's centre, or of the link's, with the mass, pose and added mass of the file."""
    model = ET.parse(folder / "world.sdf").getroot().find("world/model[@name='random']")
    inertial = model.find("link/inertial")
    place = np.array(model.findtext("pose").split(), dtype=float)
    core = np.array(model.findtext("frame[@name='core']/pose").split(), dtype=float)[:3] * (frame == "core")

    skeleton = dart.dynamics.Skeleton()
    joint, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dart.dynamics.Inertia(spatial(inertial)))
    # As gz-physics does it: gravity would pull the added mass too.
    body.setGravityMode(False)
    start = dart.math.Isometry3()
    start.set_translation(place[:3])
    start.set_rotation(Rotation.from_euler("xyz", place[3:]).as_matrix())
    joint.setRelativeTransform(start)
    joint.setLinearVelocity(job.scenario.release.velocity)
    space = dart.simulation.World()
    space.setTimeStep(step)
    space.addSkeleton(skeleton)

    mass, fluid = job.agent.mass, job.scenario.fluid
    weight = np.array([0, 0, -float(inertial.findtext("mass")) * fluid.gravity])
    lift = np.array([0, 0, fluid.density * mass.volume * fluid.gravity])
    times, path = [], []
    for k in range(1, round(2.0 / step) + 1):
        body.addExtForce(weight, np.zeros(3), False, True)
        body.addExtForce(lift, mass.cob - mass.cog, False, True)
        space.step(True)
        if k % round(0.02 / step) == 0:
            pose = body.getWorldTransform()
            times.append(k * step)
            path.append(np.array(pose.translation()) + np.array(pose.rotation()) @ core)
    return np.array(times), np.array(path)


@pytest.mark.parametrize("name", ["random", "another", "dragged"])
def test_dart_flies_as_we_do(name, jobs, export, study):
    """2 s in open water at rest, from a tilted release with a speed: the paths are a millimetre apart at most.

    DART's steps are of first order, so that of two step sizes one follows what it would do without an error. That
    holds for agents which hover, nearly, and does not for those that tumble by tens of radians a second.
    """
    agent = jobs[name].agent
    density = 1.02 * agent.mass.mass / agent.mass.volume
    scenario = Scenario(
        flow=UniformFlow(speed=0.0),
        fluid=Fluid(density=density),
        release=Release(pitch_deg=25.0, velocity=(0.4, 0.0, 0.1)),
        flight=FlightLimits(horizon=2.0),
    )
    water = density / jobs[name].scenario.fluid.density
    undamped = Coefficients(water * agent.coefficients.added_mass, agent.coefficients.origin)
    job = ExportJob("random", replace(agent, coefficients=undamped), scenario)
    folder = export("sdf", job)
    times, coarse = flight_by_dart(job, folder, 4e-4)
    _, fine = flight_by_dart(job, folder, 2e-4)
    ours = interpolate_positions(study.make_pipeline().simulator.simulate(job.agent, scenario), times)
    assert np.linalg.norm(ours[-1] - ours[0]) > 0.2
    assert np.linalg.norm(2 * fine - coarse - ours, axis=1).max() < 0.001


def test_steps_of_the_gap_are_those_of_dart(jobs, export):
    """A tumbling agent, and steps so long that their error after 1 s is centimetres: it has the same in both."""
    agent = jobs["dragged"].agent
    undamped = Coefficients(agent.coefficients.added_mass, agent.coefficients.origin)
    release = Release(pitch_deg=25.0, velocity=(0.4, 0.0, 0.1))
    scenario = Scenario(flow=UniformFlow(speed=0.0), release=release)
    job = ExportJob("random", replace(agent, coefficients=undamped), scenario)
    link = make_link(job)
    times, path = flight_by_dart(job, export("sdf", job), 0.002, "link")
    reader = read_link("Gazebo", link, scenario.fluid.density)
    steps, ours = fly_reader(reader, job, link, 10.0, 0.002), fly_own(job, link, 10.0)
    until = times <= 1.0
    found, exact = ((fly[1 : len(times) + 1] + link.position)[until] for fly in (steps, ours))
    assert np.linalg.norm(found - exact, axis=1).max() > 0.01
    np.testing.assert_allclose(path[until], found, atol=1e-6)
