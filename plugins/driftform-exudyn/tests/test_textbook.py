"""What is Exudyn's own about its integrators."""

import numpy as np
import pytest
from textbook import distance_from_textbook, random_case

from driftform.motion.path.interpolation import interpolate_positions
from driftform.testing.agents import DENSITY, sphere_agent
from driftform.water import Fluid, Scenario
from driftform.water.scenario import FlightLimits, Release
from driftform_exudyn.simulator import ExudynOptions, ExudynSimulator


@pytest.mark.parametrize("integrator", ["RK67", "RK44"])
def test_the_other_integrators_fly_the_same(integrator):
    agent, scenario = random_case(1)
    flight = ExudynSimulator(ExudynOptions(integrator=integrator, max_step=1e-3)).simulate(agent, scenario)
    assert distance_from_textbook(flight, agent, scenario, scenario.flight.horizon) < 1e-6


def test_samples_are_never_further_apart_than_the_longest_step():
    agent, scenario = random_case(0)
    for step in (0.02, 0.005):
        flight = ExudynSimulator(ExudynOptions(max_step=step)).simulate(agent, scenario)
        assert np.diff(flight.t).max() <= step * (1 + 1e-9)


def test_the_error_of_the_path_between_the_longest_steps_is_stated():
    agent, horizon = sphere_agent(0.01, 0.05, drag=0.47), 1.0
    scenario = Scenario(
        release=Release(velocity="rest"), fluid=Fluid(density=DENSITY), flight=FlightLimits(horizon=horizon)
    )
    # Longer steps than usual: what is stated is 0.1 mm or more.
    flight = ExudynSimulator(ExudynOptions(max_step=0.15)).simulate(agent, scenario)
    # The fall (m + m') v' = W - c v^2 of a sphere, with half of the displaced mass as m'.
    displaced = DENSITY * 4 / 3 * np.pi * 1e-6
    c, inertia = 0.5 * DENSITY * 0.47 * np.pi * 1e-4, 0.05 + displaced / 2
    weight = (0.05 - displaced) * scenario.fluid.gravity
    times = np.linspace(0.0, horizon, 1001)
    fallen = inertia / c * np.log(np.cosh(np.sqrt(weight * c) / inertia * times))
    error = np.abs(interpolate_positions(flight, times)[:, 2] + fallen).max()
    assert 1e-5 < error <= flight.error <= 1e-4
