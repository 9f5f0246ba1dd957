"""Other masses fly as bodies of another density do: an independent way to the same agent."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.agent import hull_mass, mass_properties
from driftform.design.inspection import GRAM, measure_gram_sensitivity
from driftform.design.opening import open_agent

WORD = "addF-tiltp-2-L-moveF-addF-tiltn-1-L-moveF-addB-tiltn-2-L-moveB-addB-tiltp-2-L-moveB"
NATIVE = {"simulator": "native"}

PERCENT = 2e-3
"""Of d_max, some 8 m: 0.2 mm, to which flights of the same body agree that were rounded differently before a wall."""


@pytest.fixture(scope="module")
def neutral():
    """The setting of a core that makes the agent weigh what it displaces: it flies far before it touches a wall."""
    heavy = open_agent(WORD, "paper", use=NATIVE)
    core = heavy.study.scenario.fluid.density * heavy.agent.mass.volume - hull_mass(heavy.agent.body)
    return f"builder.core_mass={core!r}"


SHORT = "flow.speed=2.0"
"""Flights that bounce for longer may not converge."""


@pytest.fixture(scope="module")
def opened(neutral):
    return open_agent(WORD, "paper", settings=[neutral, SHORT], use=NATIVE)


def test_a_gram_of_hull_is_a_denser_hull(opened, neutral):
    found = measure_gram_sensitivity(opened.pipeline, opened.agent, "agent")
    assert found is not None
    hull = hull_mass(opened.agent.body)
    for change, errors in ((-GRAM, found["lighter"]), (0.0, found["as_simulated"]), (GRAM, found["heavier"])):
        density = opened.agent.body.hull_density * (hull + change) / hull
        other = open_agent(WORD, "paper", settings=[neutral, SHORT, f"builder.hull_density={density!r}"], use=NATIVE)
        [flight] = other.pipeline.simulate([other.agent], "agent")
        np.testing.assert_allclose(errors, 100 - flight.fitness, atol=PERCENT)
    # A gram is 2 % of its mass, and takes it to another wall.
    assert np.abs(found["heavier"] - found["lighter"]).max() > 1


def test_ballast_stays_where_it_is_when_the_hull_is_a_gram_heavier():
    settings = ["builder.tuning=ballast", "builder.core_mass=0.01", SHORT]
    opened = open_agent(WORD, "paper", settings=settings, use=NATIVE)
    assert opened.agent.morphology is not None
    _, most = opened.pipeline.builder.find_tunings(opened.agent.morphology) or (0.0, 0.0)
    agent = opened.pipeline.realise(replace(opened.agent.morphology, tuning=0.7 * most))
    ballast, hull = agent.body.ballast, hull_mass(agent.body)
    assert ballast.volume * agent.body.ballast_density > hull and abs(ballast.centroid) > 0.01
    found = measure_gram_sensitivity(opened.pipeline, agent, "agent")
    assert found is not None
    for change, errors in ((-GRAM, found["lighter"]), (GRAM, found["heavier"])):
        denser = replace(agent.body, hull_density=agent.body.hull_density * (hull + change) / hull)
        [flight] = opened.pipeline.simulate([replace(agent, body=denser, mass=mass_properties(denser))], "agent")
        np.testing.assert_allclose(errors, 100 - flight.fitness, atol=PERCENT)


def test_a_hull_of_less_than_a_gram_has_none_to_lose():
    light = open_agent("C", "paper", settings=["builder.hull_density=500.0"], use=NATIVE)
    assert hull_mass(light.agent.body) < GRAM
    assert measure_gram_sensitivity(light.pipeline, light.agent, "agent") is None
