"""The contract of simulators is of use only if it refuses simulators that are wrong: each of these has one fault."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.interfaces import Simulator
from driftform.motion.path.curve import world_velocity
from driftform.testing import SimulatorContract
from driftform.types import End
from driftform.util.rotations import matrix_from_quaternion
from driftform_exudyn.simulator import ExudynOptions, ExudynSimulator


def fly(agent, scenario, **options):
    return ExudynSimulator(ExudynOptions(**options)).simulate(agent, scenario)


def with_coefficients(**values):
    return lambda agent, there: fly(replace(agent, coefficients=replace(agent.coefficients, **values)), there)


def with_table(name, **values):
    """Fly as if a table of the scenario had other values."""

    def flight(agent, scenario):
        table = getattr(scenario, name).model_copy(update=values)
        return fly(agent, scenario.model_copy(update={name: table}))

    return flight


def with_quaternions_the_other_way(agent, scenario):
    flight = fly(agent, scenario)
    return replace(flight, quaternion=flight.quaternion * [1, -1, -1, -1])


def with_velocity_in_the_world_frame(agent, scenario):
    flight = fly(agent, scenario)
    return replace(flight, velocity=np.hstack([world_velocity(flight), flight.velocity[:, 3:]]))


def with_velocity_through_the_water(agent, scenario):
    flight = fly(agent, scenario)
    current = np.einsum("kji,j->ki", matrix_from_quaternion(flight.quaternion), scenario.current())
    return replace(flight, velocity=flight.velocity - np.hstack([current, np.zeros_like(current)]))


def overshooting_the_outlet(agent, scenario):
    flight = fly(agent, scenario)
    beyond = flight.position[-1] + [0.01 if flight.end is End.OUTLET else 0.0, 0.0, 0.0]
    return replace(flight, position=np.vstack([flight.position[:-1], beyond]))


class NeverChecking(ExudynSimulator):
    def screen_batch(self, agents, scenarios, matters):
        return super().screen_batch(agents, scenarios, lambda index, flight: matters(index, flight) and False)


class MixingUpTheBatch(ExudynSimulator):
    def screen_batch(self, agents, scenarios, matters):
        last = len(agents) - 1
        return super().screen_batch(agents, scenarios, lambda index, flight: matters(last - index, flight))


MOTION = "test_a_motion_is_that_of_driftforms_own_integrator"
FAULTS = [
    (with_quaternions_the_other_way, "test_a_flight_starts_as_released"),
    (with_velocity_in_the_world_frame, "test_velocity_is_the_rate_of_position_over_ground"),
    (with_velocity_through_the_water, "test_a_body_released_with_the_current_drifts_with_it"),
    (overshooting_the_outlet, "test_a_flight_ends_exactly_at_the_outlet"),
    (NeverChecking, "test_a_screened_flight_that_matters_is_the_simulated_one"),
    (MixingUpTheBatch, "test_a_screened_flight_that_does_not_matter_is_unchecked_or_the_simulated_one"),
    (with_coefficients(added_mass=np.zeros((6, 6))), MOTION, "fall"),
    (with_coefficients(origin=np.zeros(3)), MOTION, "tumbling"),
    (with_coefficients(quadratic_damping=np.zeros((6, 6))), MOTION, "fall with drag"),
    (lambda a, there: fly(replace(a, mass=replace(a.mass, cob=np.zeros(3))), there), MOTION, "tumbling with weight"),
    (with_table("pipe", segments=()), MOTION, "against an elastic wall"),
    (with_table("contact", restitution=1.0), MOTION, "obliquely against a wall"),
    (with_table("contact", frequency=60.0), MOTION, "at rest against a wall"),
    (with_table("release", velocity="rest"), MOTION, "tumbling with damping"),
    (lambda *given: fly(*given, integrator="RK44", max_step=0.02), MOTION, "libration"),
]


def contract_of(kind):
    contract = SimulatorContract()
    contract.plugin = lambda: kind(ExudynOptions())
    return contract


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_simulator_is_refused(fault):
    change, test, *arguments = fault
    faulty = (
        change if isinstance(change, type) else type("Faulty", (Simulator,), {"simulate": lambda _, *a: change(*a)})
    )
    getattr(contract_of(ExudynSimulator), test)(*arguments)
    with pytest.raises(AssertionError):
        getattr(contract_of(faulty), test)(*arguments)
