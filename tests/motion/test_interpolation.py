"""What a flight is like between its samples, and what moves it."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.agent import mass_properties
from driftform.motion.path.accelerations import acceleration_at, accelerations_along, net_wrench
from driftform.motion.path.curve import world_velocity
from driftform.motion.path.interpolation import even_times, interpolate_attitudes, interpolate_positions, resample
from driftform.study import load_study
from driftform.testing.bodies import hollow_body
from driftform.testing.renderer import drifting_trajectory
from driftform.types import Agent, Coefficients, Trajectory
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Fluid, Scenario
from driftform.water.flow import UniformFlow
from driftform.water.scenario import Release

STILL = Scenario(flow=UniformFlow(speed=0.0), release=Release(velocity="rest"))


@pytest.fixture
def agent():
    body = hollow_body()
    return Agent(body, mass_properties(body), Coefficients(np.zeros((6, 6))))


@pytest.fixture(scope="module")
def flown():
    """A random agent's flight through the paper's pipe, up to its first contact with the wall."""
    study = load_study("paper", run={"seed": 0})
    pipeline = study.make_pipeline()
    found = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(5)))
    [trajectory] = pipeline.fly([found])
    free = trajectory.t < (np.inf if trajectory.contact is None else trajectory.contact)
    trajectory = replace(
        trajectory,
        t=trajectory.t[free],
        position=trajectory.position[free],
        quaternion=trajectory.quaternion[free],
        velocity=trajectory.velocity[free],
    )
    return found, study.scenario, trajectory


def test_times_are_a_step_apart_and_the_end_is_one_of_them():
    assert even_times(1.0, 0.3) == pytest.approx([0, 0.3, 0.6, 0.9, 1.0])
    assert even_times(0.9, 0.3) == pytest.approx([0, 0.3, 0.6, 0.9])
    assert even_times(0.0, 0.3) == pytest.approx([0.0])


def test_between_samples_it_turns_steadily_the_short_way_round():
    trajectory = drifting_trajectory(1.0, turn=1.2)
    coarse = Trajectory(
        trajectory.t[::20],
        trajectory.position[::20],
        trajectory.quaternion[::20] * [[1], [-1]],
        trajectory.velocity[::20],
        trajectory.end,
    )
    found = interpolate_attitudes(coarse, np.array([0.0, 0.25, 0.5, 1.0]))
    half = 1.2 * np.array([0.0, 0.25, 0.5, 1.0]) / 2
    wanted = np.column_stack([np.cos(half), 0 * half, np.sin(half), 0 * half])
    assert np.abs(np.einsum("ij,ij->i", found, wanted)) == pytest.approx(1.0)


def test_resampled_flights_lie_on_the_path_and_have_its_slope(flown):
    trajectory = flown[2]
    fine = resample(trajectory, 1000.0)
    assert np.diff(fine.t)[:-1] == pytest.approx(1e-3) and fine.t[-1] == trajectory.t[-1]
    assert fine.position == pytest.approx(interpolate_positions(trajectory, fine.t))
    slope = (
        interpolate_positions(trajectory, fine.t[1:-1] + 1e-5) - interpolate_positions(trajectory, fine.t[1:-1] - 1e-5)
    ) / 2e-5
    assert world_velocity(fine)[1:-1] == pytest.approx(slope, abs=1e-6)


def test_a_single_sample_stays_one():
    whole = drifting_trajectory()
    single = Trajectory(whole.t[:1], whole.position[:1], whole.quaternion[:1], whole.velocity[:1], whole.end)
    assert resample(single, 100.0) is single


def test_accelerations_add_up_to_the_change_of_velocity(flown):
    agent, scenario, trajectory = flown
    fine = resample(trajectory, 2000.0)
    found = accelerations_along(fine, agent, scenario)
    velocity = np.column_stack([world_velocity(fine), fine.velocity[:, 3:]])
    gained = np.trapezoid(found, fine.t, axis=0)
    size = np.abs(velocity - velocity[0]).max(axis=0).max(initial=0.0)
    assert gained == pytest.approx(velocity[-1] - velocity[0], abs=2e-4 * size)


@pytest.mark.parametrize("rates", [(0, 0, 0), (3, 1, 2)])
def test_in_vacuum_the_net_force_is_the_weight_and_the_torque_is_none(agent, rates):
    # No study can ask for so thin a fluid, and no bound is checked in a copy.
    vacuum = Scenario(flow=UniformFlow(speed=0.0), fluid=Fluid().model_copy(update={"density": 1e-12}))
    drifting = drifting_trajectory()
    trajectory = replace(drifting, velocity=drifting.velocity + np.array([0, 0, 0, *rates]))
    wrench = net_wrench(trajectory, accelerations_along(trajectory, agent, vacuum), agent.mass)
    up = matrix_from_quaternion(trajectory.quaternion)[:, 2]
    assert wrench[:, :3] == pytest.approx(-9.81 * agent.mass.mass * up, rel=1e-6)
    assert wrench[:, 3:] == pytest.approx(np.zeros((len(trajectory.t), 3)), abs=1e-9)


def test_a_body_with_the_weight_of_the_water_feels_no_force_at_rest(agent):
    density = agent.mass.mass / agent.mass.volume
    scenario = STILL.model_copy(update={"fluid": Fluid(density=density)})
    whole = drifting_trajectory()
    rest = replace(whole, velocity=np.zeros_like(whole.velocity))
    wrench = net_wrench(rest, accelerations_along(rest, agent, scenario), agent.mass)
    assert np.abs(wrench[:, :3]).max() < 1e-9 * agent.mass.mass * 9.81


def test_a_point_off_the_axis_of_a_steady_turn_is_pulled_inward(agent):
    trajectory = drifting_trajectory(turn=1.0)
    rate = trajectory.velocity[0, 4]
    none = np.zeros((len(trajectory.t), 6))
    assert acceleration_at(trajectory, none, np.array([0.2, 0.0, 0.0])) == pytest.approx(
        np.tile([-0.2 * rate**2, 0.0, 0.0], (len(trajectory.t), 1))
    )


def test_a_turn_that_grows_faster_is_followed_between_samples():
    """About one axis the angle is the cubic of its values and rates, whatever that axis is."""
    axis = np.array([2.0, -1.0, 2.0]) / 3
    t = np.linspace(0, 1, 6)

    def turned(times):
        half = (times + times**3) / 2
        return np.column_stack([np.cos(half), np.sin(half)[:, None] * axis])

    still = np.zeros((6, 3))
    velocity = np.column_stack([still, (1 + 3 * t**2)[:, None] * axis])
    fine = resample(Trajectory(t, still, turned(t), velocity, drifting_trajectory().end), 37.0)
    same = np.einsum("ij,ij->i", fine.quaternion, turned(fine.t))
    assert np.abs(same) == pytest.approx(1.0, abs=1e-14)
    assert fine.velocity[:, 3:] == pytest.approx((1 + 3 * fine.t**2)[:, None] * axis, rel=1e-9)


def test_a_turn_about_a_wandering_axis_is_followed_to_the_fourth_order():
    """With twice as many samples the attitude in between is off by a sixteenth of that at most."""

    def sample(times):
        # A body that precesses: R = Rz(2 t) Rx(3 t), so that w = 3 e_x + Rx(3 t)^T (2 e_z).
        first = np.column_stack([np.cos(times), 0 * times, 0 * times, np.sin(times)])
        c, s = np.cos(1.5 * times), np.sin(1.5 * times)
        quaternion = np.column_stack([first[:, 0] * c, first[:, 0] * s, first[:, 3] * s, first[:, 3] * c])
        omega = np.column_stack([3 + 0 * times, 2 * np.sin(3 * times), 2 * np.cos(3 * times)])
        still = np.zeros((len(times), 3))
        return Trajectory(times, still, quaternion, np.column_stack([still, omega]), drifting_trajectory().end)

    off = []
    for count in (11, 21):
        fine = resample(sample(np.linspace(0, 2, count)), 500.0)
        off.append(
            np.abs(matrix_from_quaternion(fine.quaternion) - matrix_from_quaternion(sample(fine.t).quaternion)).max()
        )
    assert off[0] < 1e-4
    assert off[0] > 12 * off[1]
