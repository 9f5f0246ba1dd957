"""Masses along the axis against closed forms, and against the properties that a body has as simulated."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent import mass_properties
from driftform.agent.mass_elements import (
    MassElement,
    ball_element,
    combine,
    core_element,
    hull_element,
    load_ballast,
    printed_hull_element,
    reweigh,
)
from driftform.testing.bodies import hollow_body
from driftform.types import Agent, Coefficients

BODY = hollow_body()
MASS = mass_properties(BODY)
AGENT = Agent(BODY, MASS, Coefficients(0.01 * np.eye(6)))


def test_hull_and_core_are_the_body_as_simulated() -> None:
    found = combine([hull_element(BODY), core_element(BODY)], MASS)
    assert found.mass == pytest.approx(MASS.mass, rel=1e-12)
    np.testing.assert_allclose(found.cog, MASS.cog, atol=1e-12)
    np.testing.assert_allclose(found.inertia, MASS.inertia, rtol=1e-9)


def test_a_print_of_the_simulated_mass_and_balance_is_the_simulated_body() -> None:
    for x in (None, float(MASS.cog[0])):
        found = reweigh(AGENT, MASS.mass, x).mass
        assert found.mass == pytest.approx(MASS.mass, rel=1e-12)
        np.testing.assert_allclose(found.cog, MASS.cog, atol=1e-12)
        np.testing.assert_allclose(found.inertia, MASS.inertia, rtol=1e-9)


def test_two_balls_are_a_dumbbell() -> None:
    found = combine([ball_element(1.0, -0.3, 0.1), ball_element(3.0, 0.1, 0.2)], MASS)
    assert found.mass == 4.0
    assert found.cog[0] == pytest.approx(0.0, abs=1e-15)
    own = 0.4 * (1.0 * 0.1**2 + 3.0 * 0.2**2)
    assert np.diag(found.inertia) == pytest.approx([own, own + 0.12, own + 0.12])


@given(share=st.floats(0.05, 20.0))
def test_without_a_measured_balance_the_material_keeps_its_distribution(share: float) -> None:
    hull = MASS.mass - BODY.core.mass
    found = printed_hull_element(BODY, BODY.core.mass + share * hull)
    whole = hull_element(BODY)
    assert found.mass == pytest.approx(share * whole.mass, rel=1e-6)
    assert found.x == whole.x
    assert found.transverse == pytest.approx(share * whole.transverse, rel=1e-6)


@given(x=st.floats(-0.02, 0.02), mass=st.floats(0.055, 0.2))
def test_a_measured_balance_is_that_of_print_and_core_together(x: float, mass: float) -> None:
    found = reweigh(AGENT, mass, x).mass
    assert found.mass == pytest.approx(mass, rel=1e-12)
    assert found.cog[0] == pytest.approx(x, abs=1e-12)


def test_the_displaced_volume_is_that_of_the_shape() -> None:
    found = reweigh(AGENT, 2 * MASS.mass).mass
    assert found.volume == MASS.volume
    np.testing.assert_array_equal(found.cob, MASS.cob)


def test_a_print_lighter_than_its_core_is_refused() -> None:
    with pytest.raises(ValueError, match="core"):
        reweigh(AGENT, BODY.core.mass)
    with pytest.raises(ValueError, match="mass above 0"):
        combine([MassElement(1.0, 0.0), MassElement(-1.0, 0.1)], replace(MASS))


@dataclass(frozen=True)
class Lump:
    """What hangs on an agent."""

    ballast: float
    ballast_x: float
    ballast_density: float


def test_a_ballast_is_a_point_that_displaces_its_own_water() -> None:
    load = Lump(0.03, 0.07, 11_000.0)
    found = load_ballast(MASS, load)
    point = combine(
        [
            MassElement(MASS.mass, float(MASS.cog[0]), MASS.inertia[0, 0], MASS.inertia[1, 1]),
            MassElement(0.03, 0.07),
        ],
        MASS,
    )
    assert found.mass == pytest.approx(point.mass, rel=1e-12)
    np.testing.assert_allclose(found.cog, point.cog, rtol=1e-12)
    np.testing.assert_allclose(found.inertia, point.inertia, rtol=1e-9)
    water = 0.03 / 11_000.0
    assert found.volume == pytest.approx(MASS.volume + water, rel=1e-12)
    moment = MASS.volume * MASS.cob[0] + water * 0.07
    np.testing.assert_allclose(found.cob, [moment / (MASS.volume + water), 0.0, 0.0], rtol=1e-12)


def test_without_ballast_nothing_changes() -> None:
    assert load_ballast(MASS, Lump(0.0, 0.1, 1000.0)) is MASS
