"""The contract of simulators is of use only if it refuses simulators that are wrong: each of these has one fault."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from driftform.interfaces import Simulator
from driftform.testing import SimulatorContract
from driftform.types import Agent, Coefficients, End, Trajectory
from driftform.water import Scenario
from driftform_exudyn.simulator import ExudynOptions, ExudynSimulator

Flight = Callable[[Agent, Scenario], Trajectory]


def sound(agent: Agent, scenario: Scenario) -> Trajectory:
    return ExudynSimulator(ExudynOptions()).simulate(agent, scenario)


def without_added_mass(agent, scenario):
    return sound(replace(agent, coefficients=Coefficients(np.zeros((6, 6)))), scenario)


def with_coefficients_about_the_origin(agent, scenario):
    return sound(replace(agent, coefficients=replace(agent.coefficients, origin=np.zeros(3))), scenario)


def without_damping(agent, scenario):
    return sound(replace(agent, coefficients=replace(agent.coefficients, quadratic_damping=np.zeros((6, 6)))), scenario)


def without_buoyancy_at_its_centre(agent, scenario):
    return sound(replace(agent, mass=replace(agent.mass, cob=np.zeros(3))), scenario)


def with_quaternions_the_other_way(agent, scenario):
    flight = sound(agent, scenario)
    return replace(flight, quaternion=flight.quaternion * [1, -1, -1, -1])


def with_velocity_in_the_world_frame(agent, scenario):
    from driftform.motion.path.curve import world_velocity

    flight = sound(agent, scenario)
    return replace(flight, velocity=np.hstack([world_velocity(flight), flight.velocity[:, 3:]]))


def with_velocity_through_the_water(agent, scenario):
    from driftform.util.rotations import matrix_from_quaternion

    flight = sound(agent, scenario)
    current = np.einsum("kji,j->ki", matrix_from_quaternion(flight.quaternion), scenario.current())
    return replace(flight, velocity=flight.velocity - np.hstack([current, np.zeros_like(current)]))


def without_walls(agent, scenario):
    if not scenario.pipe.segments:
        return sound(agent, scenario)
    (segment,) = scenario.pipe.segments
    wide = scenario.pipe.model_copy(update={"segments": (segment.model_copy(update={"radius": 50.0}),)})
    return sound(agent, scenario.model_copy(update={"pipe": wide}))


def with_an_elastic_wall(agent, scenario):
    contact = scenario.contact.model_copy(update={"restitution": 1.0})
    return sound(agent, scenario.model_copy(update={"contact": contact}))


def with_a_soft_wall(agent, scenario):
    contact = scenario.contact.model_copy(update={"frequency": scenario.contact.frequency / 5})
    return sound(agent, scenario.model_copy(update={"contact": contact}))


def overshooting_the_outlet(agent, scenario):
    flight = sound(agent, scenario)
    if flight.end is not End.OUTLET:
        return flight
    return replace(flight, position=np.vstack([flight.position[:-1], flight.position[-1] + [0.01, 0, 0]]))


def released_at_rest(agent, scenario):
    release = scenario.release.model_copy(update={"velocity": "rest"})
    return sound(agent, scenario.model_copy(update={"release": release}))


def with_a_coarse_integrator(agent, scenario):
    return ExudynSimulator(ExudynOptions(integrator="RK44", max_step=0.02)).simulate(agent, scenario)


class Faulty(Simulator):
    name = "faulty"

    def __init__(self, flight: Flight) -> None:
        self.flight = flight

    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        return self.flight(agent, scenario)


class NeverChecking(ExudynSimulator):
    def screen_batch(self, agents, scenarios, matters):
        return super().screen_batch(agents, scenarios, lambda index, flight: matters(index, flight) and False)


class MixingUpTheBatch(ExudynSimulator):
    def screen_batch(self, agents, scenarios, matters):
        last = len(agents) - 1
        return super().screen_batch(agents, scenarios, lambda index, flight: matters(last - index, flight))


class Contract(SimulatorContract):
    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator

    def plugin(self) -> Simulator:
        return self.simulator


@pytest.mark.parametrize(
    ("fault", "test"),
    [
        (with_quaternions_the_other_way, "test_a_flight_starts_as_released"),
        (with_velocity_in_the_world_frame, "test_velocity_is_the_rate_of_position_over_ground"),
        (with_velocity_through_the_water, "test_a_body_released_with_the_current_drifts_with_it"),
        (overshooting_the_outlet, "test_a_flight_ends_exactly_at_the_outlet"),
        (NeverChecking, "test_a_screened_flight_that_matters_is_the_simulated_one"),
        (MixingUpTheBatch, "test_a_screened_flight_that_does_not_matter_is_unchecked_or_the_simulated_one"),
    ],
)
def test_a_faulty_simulator_is_refused(fault, test):
    getattr(Contract(ExudynSimulator(ExudynOptions())), test)()
    with pytest.raises(AssertionError):
        getattr(Contract(fault(ExudynOptions()) if isinstance(fault, type) else Faulty(fault)), test)()


@pytest.mark.parametrize(
    ("fault", "what"),
    [
        (without_added_mass, "fall"),
        (with_coefficients_about_the_origin, "tumbling"),
        (without_damping, "fall with drag"),
        (without_buoyancy_at_its_centre, "tumbling with weight"),
        (with_quaternions_the_other_way, "tumbling"),
        (without_walls, "against an elastic wall"),
        (with_an_elastic_wall, "obliquely against a wall"),
        (with_a_soft_wall, "at rest against a wall"),
        (released_at_rest, "tumbling with damping"),
        (with_a_coarse_integrator, "libration"),
    ],
)
def test_a_faulty_simulator_flies_another_motion(fault, what):
    Contract(Faulty(sound)).test_a_motion_is_that_of_driftforms_own_integrator(what)
    with pytest.raises(AssertionError):
        Contract(Faulty(fault)).test_a_motion_is_that_of_driftforms_own_integrator(what)
