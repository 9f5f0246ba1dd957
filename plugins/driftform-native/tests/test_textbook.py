"""Flights against the textbook's equations, and how well a flight knows its own error."""

import numpy as np
import pytest
from textbook import distance_from_textbook, random_case

from driftform.types import End
from driftform_native.simulator import NativeOptions, NativeSimulator

HORIZON = 3.0
SEEDS = range(10)


def flown(seed: int, **options):
    """A flight, and its largest distance (m) from the textbook's."""
    agent, scenario = random_case(seed, HORIZON)
    flight = NativeSimulator(NativeOptions(**options)).simulate(agent, scenario)
    assert flight.end == End.HORIZON
    assert np.linalg.norm(np.diff(flight.position, axis=0), axis=1).sum() > 1.0, "it has to go somewhere"
    return flight, distance_from_textbook(flight, agent, scenario, HORIZON)


# Between samples the path is a cubic, and steps of 0.05 s are too long for a micrometre.
@pytest.mark.parametrize(("options", "within"), [({}, 1e-3), ({"tolerance": 1e-10, "max_step": 0.01}, 1e-6)])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_flight_agrees_with_fossens_equations_as_its_tolerance_says(seed, options, within):
    assert flown(seed, **options)[1] < within


def test_an_accuracy_that_is_asked_for_is_met_by_tightening_the_tolerance():
    for seed in SEEDS:
        flight, error = flown(seed, accuracy=1e-5, tolerance=1e-2, max_step=0.01)
        assert flight.error <= 1e-5
        assert error <= 1e-5
