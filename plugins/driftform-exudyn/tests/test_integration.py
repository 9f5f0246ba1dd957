"""Motions that Exudyn integrates."""

import exudyn
import numpy as np
import pytest
from textbook import distance_from_textbook, random_case

from driftform.motion.forces.water_forces import WaterForces
from driftform.motion.path.interpolation import interpolate_positions
from driftform.study import load_study
from driftform.testing.agents import DENSITY, sphere_agent
from driftform.testing.simulator import largest_distance
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import UniformFlow
from driftform.water.scenario import FlightLimits, Release
from driftform_exudyn import integration
from driftform_exudyn.integration import integrate_motion, make_settings
from driftform_exudyn.simulator import ExudynOptions, ExudynSimulator
from driftform_exudyn.system import exudyn_system

PIPELINE = load_study("paper").make_pipeline()
SETTINGS = make_settings("DOPRI5", horizon=2.0, tolerance=1e-8, max_step=0.05)


def make_agent(seed):
    return PIPELINE.make_agent(PIPELINE.grammar.random(np.random.default_rng(seed)))


def test_agents_with_log_law_drag_and_contact_fly_alike_by_both():
    settings = ["contact.friction=0", "flight.horizon=6"]
    pipelines = [
        load_study("pipe-inspection", settings, use={"simulator": use}).make_pipeline() for use in ("native", "exudyn")
    ]
    rng, touched = np.random.default_rng(5), 0
    for _ in range(4):
        agent = pipelines[0].make_agent(pipelines[0].grammar.random(rng))
        one, other = (p.simulator.simulate(agent, p.scenario) for p in pipelines)
        assert not one.end.failed and not other.end.failed
        times = np.linspace(0.0, min(one.t[-1], other.t[-1]), 500)
        assert largest_distance(*(interpolate_positions(f, times) for f in (one, other))) < 1e-3
        touched += one.contact is not None
    assert touched > 1


@pytest.mark.parametrize("function", ["force", "fill_sample", "fill_mass"])
def test_an_interruption_stops_a_flight_as_it_stops_anything(function, monkeypatch):
    calls = iter(range(10_000))
    before = getattr(WaterForces, function)

    def interrupted(*arguments):
        if next(calls) == 50:
            raise KeyboardInterrupt
        return before(*arguments)

    monkeypatch.setattr(WaterForces, function, interrupted)
    with pytest.raises(KeyboardInterrupt):
        integrate_motion(make_agent(1), PIPELINE.scenario, SETTINGS, 10_000)


def test_the_step_limit_ends_a_flight():
    assert len(integrate_motion(make_agent(1), PIPELINE.scenario, SETTINGS, 17)) == 18


def test_the_tolerance_grows_along_a_flight_and_the_settings_remain(monkeypatch):
    growing = integrate_motion(make_agent(1), PIPELINE.scenario, SETTINGS, 10_000)
    assert SETTINGS.timeIntegration.absoluteTolerance == 1e-8
    monkeypatch.setattr(integration.solver, "grow_tolerance", lambda tolerance, _: tolerance)
    constant = integrate_motion(make_agent(1), PIPELINE.scenario, SETTINGS, 10_000)
    assert len(growing) < 0.95 * len(constant)


def test_two_agents_in_one_system_fly_as_each_does_alone():
    agents, ends = [make_agent(1), make_agent(2)], []
    for chosen in ([0], [1], [0, 1]):
        systems = []
        for number in chosen:
            systems.append(exudyn_system(agents[number], PIPELINE.scenario, systems[0] if systems else None))
        systems[0].mbs.Assemble()
        settings = integration.make_settings("RK44", 0.5, 1e-8, 0.001)
        systems[0].mbs.SolveDynamic(settings)
        ends += [systems[0].mbs.GetNodeOutput(s.node, exudyn.OutputVariableType.Position) for s in systems]
    assert np.array(ends[2:]) == pytest.approx(np.array(ends[:2]), abs=1e-9)
    assert np.linalg.norm(ends[0] - ends[1]) > 1e-4


@pytest.mark.parametrize("depth", [1e-6, 3e-5, 3e-4])
def test_a_touch_between_the_ends_of_a_step_is_found(depth):
    """A heavy sphere that is thrown at the ceiling: its parabola would lead to a depth (m) in it."""
    radius, mass, bore, water = 0.02, 0.1, 0.2, 1024.0
    displaced = water * 4 / 3 * np.pi * radius**3
    fall, room = (mass - displaced) * 9.81 / (mass + displaced / 2), bore - radius
    speed = np.sqrt(2 * fall * (room + depth))
    scenario = Scenario(
        pipe=Pipe(segments=(Segment(start=(-1, 0, 0), end=(9, 0, 0), radius=bore),)),
        fluid=Fluid(density=water),
        flow=UniformFlow(speed=0.0),
        release=Release(velocity=(0.0, 0.0, float(speed))),
        flight=FlightLimits(horizon=0.5),
    )
    flight = ExudynSimulator(ExudynOptions()).simulate(sphere_agent(radius, mass), scenario)
    time = (speed - np.sqrt(speed**2 - 2 * fall * room)) / fall
    assert flight.contact == pytest.approx(time, abs=1e-7 / np.sqrt(2 * fall * depth))
    assert flight.position[-1, 2] < scenario.release_position()[2] + room - 1e-3


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
