"""Sensors read what closed forms say: weightless in free fall, g at rest, rho g h under water."""

import numpy as np
import pytest

from driftform.agent import mass_properties
from driftform.motion.path.accelerations import accelerations_along
from driftform.testing.bodies import hollow_body
from driftform.testing.renderer import drifting_trajectory
from driftform.types import Agent, Coefficients, Trajectory
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import UniformFlow
from driftform_robotics import sensors

PIPE = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0),))
ORIGIN = np.zeros(3)


@pytest.fixture
def agent():
    body = hollow_body()
    return Agent(body, mass_properties(body), Coefficients(np.zeros((6, 6))))


def at(position, angle=0.0):
    """A flight of one sample, at rest."""
    pitched = np.array([[np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0]])
    return Trajectory(np.zeros(1), np.array([position]), pitched, np.zeros((1, 6)), drifting_trajectory().end)


def test_in_free_fall_an_accelerometer_at_the_centre_of_gravity_reads_nothing(agent):
    # No study may have so little water, but a formula must.
    nothing = Fluid().model_copy(update={"density": 1e-12})
    vacuum = Scenario(flow=UniformFlow(speed=0.0)).model_copy(update={"fluid": nothing})
    flight = drifting_trajectory()
    found = sensors.specific_force(
        flight, accelerations_along(flight, agent, vacuum), agent.mass.cog, vacuum.fluid.gravity
    )
    assert np.abs(found).max() < 1e-9


@pytest.mark.parametrize("angle", [0.0, 0.4, -1.2, np.pi / 2])
def test_at_rest_it_reads_gravity_upward(agent, angle):
    flight = at((1.0, 0.0, 0.0), angle)
    found = sensors.specific_force(flight, np.zeros((1, 6)), ORIGIN, 9.81)
    # Nose down by a pitch angle, the upward direction points aft.
    assert found[0] == pytest.approx([-9.81 * np.sin(angle), 0.0, 9.81 * np.cos(angle)])


def test_pressure_grows_by_an_atmosphere_in_ten_metres_of_fresh_water():
    fresh = Fluid(density=999.1)
    found = sensors.pressure(np.array([2.0, 0.0, -10.0]), 0.0, fresh)
    assert found == pytest.approx([101_325, 101_325, 101_325 + 999.1 * 9.81 * 10])
    assert found[2] / found[0] == pytest.approx(2.0, abs=0.05)


def test_the_surface_is_the_water_level_or_the_top_of_the_pipe():
    assert sensors.surface_height(Scenario(pipe=PIPE)) == 1.0
    level = Scenario(pipe=PIPE, fluid=Fluid(water_level=0.4))
    assert sensors.surface_height(level) == 0.4
    assert sensors.surface_height(Scenario()) == 0.0
    steep = Segment(start=(0.0, 0.0, 0.0), end=(3.0, 0.0, 4.0), radius=1.0)
    assert sensors.surface_height(Scenario(pipe=Pipe(segments=(steep,)))) == pytest.approx(0.6)


def test_a_sensor_is_where_it_is_mounted():
    flight = at((1.0, 0.2, -0.3), np.pi / 2)
    assert sensors.point_positions(flight, np.array([0.1, 0.0, 0.0]))[0] == pytest.approx([1.0, 0.2, -0.4])
