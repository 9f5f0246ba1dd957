"""How a body hangs in the water."""

import math
from dataclasses import replace

import numpy as np
import pytest

from driftform.motion.forces.model import flight_model
from driftform.motion.path.stability import eigenvalues, stable_rest
from driftform.testing.agents import Spheroid
from driftform.water import Scenario


@pytest.mark.parametrize("share", [0.8, 1.2])
@pytest.mark.parametrize("ahead", [-0.01, 0.01])
def test_a_body_whose_centres_coincide_hangs_by_its_added_mass(share, ahead):
    """Its net force accelerates the added mass too, whose centre lies ahead of the body's: it turns until that follows."""
    agent = Spheroid(0.06, 0.02).agent()
    coefficients = replace(agent.coefficients, origin=np.array([ahead, 0.0, 0.0]))
    agent = replace(agent, mass=replace(agent.mass, mass=share * agent.mass.mass), coefficients=coefficients)
    rest = stable_rest(flight_model(agent, Scenario()))
    assert abs(rest.pitch) == pytest.approx(math.pi / 2)
    assert rest.eigenvalues.real.max() < 0.01
    assert eigenvalues(rest.model, 0.0, -rest.pitch).real.max() > 0.1, "turned over it does not stay"


@pytest.mark.parametrize("share", [0.9, 1.1])
@pytest.mark.parametrize("ahead", [-0.01, 0.01])
def test_a_body_hangs_with_its_heavy_end_down(share, ahead):
    agent = Spheroid(0.06, 0.02).agent()
    heavy = replace(agent.mass, mass=share * agent.mass.mass, cog=np.array([ahead, 0.0, 0.0]))
    rest = stable_rest(flight_model(replace(agent, mass=heavy), Scenario()))
    # Pitch is positive with the fore end down.
    assert rest.pitch == math.copysign(math.pi / 2, ahead)
    assert rest.eigenvalues.real.max() < 0.01
