"""MuJoCo itself: what it makes of the files, and the forces that it computes from them."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from robots import random_states

from driftform.interfaces import ExportJob
from driftform.motion.forces.inertia import added_mass_at
from driftform.study import load_study
from driftform.util.rotations import matrix_from_quaternion
from driftform_robotics.models.ellipsoid import added_mass_factors, fit_spheroid
from driftform_robotics.models.gap import TIMES, fly_own
from driftform_robotics.models.link import make_link
from driftform_robotics.models.mjcf import MjcfExporter


def inertia_of_body(model, body):
    """About its COG, in the body's axes: MuJoCo keeps it along principal ones."""
    axes = matrix_from_quaternion(model.body_iquat[body])
    return np.asarray(axes @ np.diag(model.body_inertia[body]) @ axes.T)


def load(path):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data


def fluid_forces(path, state):
    """Force and torque about the COG, body axes, that MuJoCo's fluid puts on the agent."""
    model, data = load(path)
    data.qpos[3:7] = quaternion(state.R)
    data.qvel[:3], data.qvel[3:] = state.velocity, state.omega
    mujoco.mj_forward(model, data)
    force = np.array(data.qfrc_fluid)
    # A free joint's first three rates are along the world's axes, the others along the body's.
    return np.concatenate((state.R.T @ force[:3], force[3:]))


def quaternion(R):
    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, R.ravel())
    return found


@pytest.mark.parametrize("name", ["agent.xml", "scene.xml"])
def test_it_reads_the_mass_the_centre_and_the_inertia(name, job, export):
    """Nine tenths of the least added mass, and the added inertia about transverse axes, are in them."""
    model, _ = load(export("mjcf", job) / name)
    own, added = job.agent.mass, np.diag(added_mass_at(job.agent.coefficients, job.agent.mass.cog))
    assert model.body_mass[1] == pytest.approx(own.mass + 0.9 * min(added[:2]), rel=1e-10)
    np.testing.assert_allclose(model.body_ipos[1], 0, atol=1e-15)
    inertia = own.inertia + np.diag([0.0, 1.0, 1.0]) * added[4:].mean()
    np.testing.assert_allclose(inertia_of_body(model, 1), inertia, rtol=1e-8, atol=1e-8 * inertia.max())
    assert model.body_mass[2] < 1e-8 * own.mass


def test_it_reads_the_urdf_as_a_body_that_floats(job, export):
    model, _ = load(export("urdf", job) / "agent.urdf")
    expected = job.agent.mass
    assert model.nv == 6
    assert model.body_mass.sum() == pytest.approx(expected.mass, rel=1e-10)
    np.testing.assert_allclose(model.body_ipos[-1], 0, atol=1e-15)
    np.testing.assert_allclose(
        inertia_of_body(model, model.nbody - 1), expected.inertia, rtol=1e-8, atol=1e-8 * expected.inertia.max()
    )


def test_without_a_floating_joint_it_welds_the_urdf_to_the_world(jobs, export):
    model, _ = load(export("urdf", jobs["random"], floating=False) / "agent.urdf")
    assert model.nv == 0


def test_the_agent_is_released_where_and_as_fast_as_in_the_scenario(job, export):
    model, data = load(export("mjcf", job) / "agent.xml")
    release = job.scenario.release
    core = data.site("core").xpos
    np.testing.assert_allclose(core, release.position, atol=1e-12)
    expected = job.scenario.current() if release.velocity == "current" else release.velocity
    np.testing.assert_allclose(data.qvel, [*expected, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(model.opt.wind, job.scenario.current(), atol=1e-12)


def test_weight_and_buoyancy_act_where_they_do(job, export):
    """The moment of buoyancy rights the agent, which compensated gravity at the COG alone would not."""
    model, data = load(export("mjcf", job) / "agent.xml")
    mass, fluid = job.agent.mass, job.scenario.fluid
    R = matrix_from_quaternion(job.scenario.release_quaternion())
    lift = np.array([0, 0, fluid.density * mass.volume * fluid.gravity])
    moment = np.cross(mass.cob - mass.cog, R.T @ lift)
    carried = data.qfrc_gravcomp[:3] - [0, 0, (model.body_mass[1] - mass.mass) * fluid.gravity]
    np.testing.assert_allclose(carried, lift, rtol=1e-9)
    np.testing.assert_allclose(data.qfrc_gravcomp[3:], moment, rtol=1e-7, atol=1e-9 * np.abs(moment).max())


@pytest.mark.parametrize("name", ["random", "another"])
def test_coriolis_forces_of_added_mass_are_ours_but_for_the_turning(name, jobs, export):
    """Munk's moment and what goes with it: -C_A(nu_r) nu_r with the matrix that the ellipsoid was fitted to.

    MuJoCo's integrals are a quadrature, which is 1 % off.
    """
    job = jobs[name]
    added = added_mass_at(job.agent.coefficients, job.agent.mass.cog)
    folder = export("mjcf", job)
    model, _ = load(folder / "agent.xml")
    centre = model.geom("water").pos[0]
    for state in random_states(10):
        slow = replace(state, omega=np.zeros(3))
        nu = slow.R.T @ (slow.velocity - job.scenario.current())
        # What is in the mass has the momentum of a point, and no moment.
        momentum = added[:3, :3] @ nu - (model.body_mass[1] - job.agent.mass.mass) * nu
        turning = added[3:, :3] @ nu
        expected = np.concatenate((np.zeros(3), np.cross(momentum, nu)))
        assert np.abs(turning - np.cross([centre, 0, 0], momentum)).max() < 0.01 * np.abs(turning).max() + 1e-12
        found = fluid_forces(folder / "agent.xml", slow)
        np.testing.assert_allclose(found[3:], expected[3:], atol=0.02 * np.abs(expected[3:]).max())
        np.testing.assert_allclose(found[:3], 0, atol=1e-9)


def test_added_mass_has_the_inertia_that_is_in_the_mass(jobs, export):
    """The comment in the file says what MuJoCo ignores."""
    job = jobs["another"]
    model, data = load(export("mjcf", job) / "agent.xml")
    mass, fluid = job.agent.mass, job.scenario.fluid
    net = (fluid.density * mass.volume - mass.mass) / model.body_mass[1] * fluid.gravity
    np.testing.assert_allclose(data.qacc[:3], [0, 0, net], atol=1e-6 * abs(net))
    assert "ignores the inertia of added mass" in (export("mjcf", job) / "agent.xml").read_text(encoding="utf-8")


def test_the_agent_stays_in_the_pipe(jobs, export):
    """Three seconds of a buoyant agent: it rises to the wall, and the planks hold it."""
    job = jobs["another"]
    model, data = load(export("mjcf", job, step=0.002) / "scene.xml")
    touched = False
    for _ in range(1500):
        mujoco.mj_step(model, data)
        touched = touched or data.ncon > 0
    assert touched
    assert np.isfinite(data.qpos).all()
    assert np.hypot(*data.site("core").xpos[1:]) < 1.0


@pytest.mark.parametrize("ratio", [0.02, 0.3, 1.0, 3.0, 50.0])
def test_the_fit_gives_back_any_spheroid_flat_ones_too(ratio):
    k1, k2, _ = added_mass_factors(ratio)
    displaced = 1024 * 4 / 3 * np.pi * 0.06**3 * ratio**2
    assert fit_spheroid(k1 * displaced, k2 * displaced, 1024.0) == pytest.approx((0.06, 0.06 * ratio), rel=1e-6)


def test_the_gap_of_ten_agents_is_the_one_that_mujoco_flies(tmp_path):
    study = load_study("pipe-inspection", run={"seed": 0})
    pipeline, rng = study.make_pipeline(), np.random.default_rng(3)
    for seed in range(10):
        job = ExportJob("agent", pipeline.make_agent(pipeline.grammar.random(rng)), study.scenario)
        MjcfExporter(MjcfExporter.Options()).write(job, tmp_path / f"{seed}-mjcf")
        path = tmp_path / f"{seed}-mjcf" / "agent.xml"
        printed = [float(d) for d in re.findall(r"(\S+) m after \d s", path.read_text(encoding="utf-8"))]
        model = mujoco.MjModel.from_xml_path(str(path))
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        link, found = make_link(job), []
        ours = fly_own(job, link, TIMES[-1])
        for time in TIMES:
            while data.time < time - 1e-9:
                mujoco.mj_step(model, data)
            moved = data.qpos[:3] - link.position - time * job.scenario.current()
            found.append(np.linalg.norm(moved - ours[round(time / TIMES[-1] * (len(ours) - 1))]))
        assert printed == pytest.approx(found, rel=0.03, abs=2e-3)
