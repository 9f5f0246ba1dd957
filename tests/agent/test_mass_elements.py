"""Masses along the axis against closed forms, and against the properties that a body has as simulated."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent import MassElement, mass_properties
from driftform.agent.mass import hull_moments
from driftform.testing.bodies import hollow_body
from driftform.types import Agent, Coefficients

BODY = hollow_body()
MASS = mass_properties(BODY)
AGENT = Agent(BODY, MASS, Coefficients(0.01 * np.eye(6)))


def print_agent(mass, x=None):
    """The agent as printed."""
    return MassElement.reweigh(AGENT, MassElement.of_print(BODY, mass, x))


def test_a_print_of_the_simulated_mass_and_balance_is_the_simulated_body():
    for x in (None, float(MASS.cog[0])):
        found = print_agent(MASS.mass, x).mass
        assert found.mass == pytest.approx(MASS.mass, rel=1e-12)
        np.testing.assert_allclose(found.cog, MASS.cog, atol=1e-12)
        np.testing.assert_allclose(found.inertia, MASS.inertia, rtol=1e-9)


def test_two_balls_are_a_dumbbell():
    found = MassElement.reweigh(AGENT, [MassElement.of_ball(1.0, -0.3, 0.1), MassElement.of_ball(3.0, 0.1, 0.2)]).mass
    assert found.mass == 4.0
    assert found.cog[0] == pytest.approx(0.0, abs=1e-15)
    own = 0.4 * (1.0 * 0.1**2 + 3.0 * 0.2**2)
    assert np.diag(found.inertia) == pytest.approx([own, own + 0.12, own + 0.12])


@given(share=st.floats(0.05, 20.0))
def test_without_a_measured_balance_the_material_keeps_its_distribution(share):
    hull = MASS.mass - BODY.core.mass
    found, _ = MassElement.of_print(BODY, BODY.core.mass + share * hull)
    whole, _ = MassElement.of_print(BODY, MASS.mass)
    assert whole.x == hull_moments(BODY).centroid
    assert found.mass == pytest.approx(share * whole.mass, rel=1e-6)
    assert found.x == whole.x
    assert found.transverse == pytest.approx(share * whole.transverse, rel=1e-6)


@given(x=st.floats(-0.02, 0.02), mass=st.floats(0.055, 0.2), cog=st.sampled_from([0.0, 0.004]))
def test_a_measured_balance_is_that_of_print_and_core_together(x, mass, cog):
    body = replace(BODY, core=replace(BODY.core, cog=cog))
    found = MassElement.reweigh(AGENT, MassElement.of_print(body, mass, x)).mass
    assert found.mass == pytest.approx(mass, rel=1e-12)
    assert found.cog[0] == pytest.approx(x, abs=1e-12)


def test_the_displaced_volume_is_that_of_the_shape():
    found = print_agent(2 * MASS.mass).mass
    assert found.volume == MASS.volume
    np.testing.assert_array_equal(found.cob, MASS.cob)


def test_a_print_lighter_than_its_core_is_refused():
    with pytest.raises(ValueError, match="core"):
        print_agent(BODY.core.mass)
    with pytest.raises(ValueError, match="mass above 0"):
        MassElement.reweigh(AGENT, [MassElement(1.0, 0.0), MassElement(-1.0, 0.1)])
