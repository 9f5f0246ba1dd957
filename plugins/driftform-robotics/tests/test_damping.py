from dataclasses import replace

import numpy as np
import pytest

from driftform.motion.forces.body_drag import estimate_drag
from driftform.motion.forces.terminal import terminal_speeds
from driftform.testing.bodies import cylinder_body
from driftform.types import Agent, Coefficients, MassProperties
from driftform.water import Fluid
from driftform_robotics.models.fitting import fit_products
from driftform_robotics.models.link import MIN_SPEED, make_link, quadratic_damping, quadratic_wrench, reference_speed


@pytest.fixture
def cylinder():
    """20 cm long, 2 cm thick, its COG 3 cm ahead of its middle."""
    body = cylinder_body(0.2, 0.01)
    mass = MassProperties(0.08, np.array([0.03, 0, 0]), 1e-4 * np.eye(3), 6.28e-5, np.zeros(3))
    return Agent(body, mass, Coefficients(0.01 * np.eye(6), drag=estimate_drag(body, Fluid().viscosity)))


def test_it_is_the_drag_by_strips_along_each_axis_alone(cylinder):
    fluid, speed = Fluid(), 0.4
    D = quadratic_damping(cylinder, fluid, speed)
    for j in range(6):
        nu = np.zeros(6)
        nu[j] = speed if j < 3 else speed / 0.1
        both = (quadratic_wrench(cylinder, fluid, nu) - quadratic_wrench(cylinder, fluid, -nu)) / 2
        np.testing.assert_allclose(-D @ (np.abs(nu) * nu), both, rtol=1e-9, atol=1e-12)


def test_across_it_is_the_cylinders_textbook_drag(cylinder):
    """1/2 rho C_d d L with White's 0.82 for 10 diameters and friction, and creeping, at its middle, 3 cm behind the COG.

    The resistance to creeping is that of a spheroid of 0.2 m with the surface of the cylinder, 0.0132 m2: by Thomsen's
    formula it is 26.70 mm thick.
    """
    fluid, speed = Fluid(), 0.4
    D = quadratic_damping(cylinder, fluid, speed)
    reynolds = speed * 0.02 / fluid.viscosity
    a, b = 0.1, 0.01335
    e = (1 - (b / a) ** 2) ** 0.5
    # Happel and Brenner: 32 pi a e^3 / [2 e + (3 e^2 - 1) ln((1 + e) / (1 - e))].
    creeping = 32 * np.pi * a * e**3 / (2 * e + (3 * e**2 - 1) * np.log((1 + e) / (1 - e)))
    expected = 0.5 * fluid.density * (0.82 + 1.96 / reynolds**0.5) * 0.02 * 0.2
    expected += fluid.density * fluid.viscosity * creeping / speed
    assert D[1, 1] == pytest.approx(expected, rel=1e-6)
    assert D[2, 2] == pytest.approx(expected, rel=1e-6)
    assert D[5, 1] == pytest.approx(-0.03 * expected, rel=1e-6)
    assert D[4, 2] == pytest.approx(0.03 * expected, rel=1e-6)


def test_damping_by_matrices_about_the_centre_of_gravity_stays_as_it_is(jobs):
    job = jobs["skewed"]
    agent = job.agent
    D = quadratic_damping(agent, Fluid(), 0.3)
    np.testing.assert_allclose(D, agent.coefficients.quadratic_damping, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(make_link(job).linear_damping, agent.coefficients.linear_damping, rtol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_it_takes_energy_however_the_agent_moves_across_and_turns(cylinder, seed):
    """The columns are added up, which the strips' drag is not: still no motion may gain by it."""
    rng = np.random.default_rng(seed)
    D = quadratic_damping(cylinder, Fluid(), 0.4)
    for _ in range(200):
        nu = rng.normal(size=6) * [1, 1, 1, 10, 10, 10]
        assert nu @ D @ (np.abs(nu) * nu) > 0


def test_the_terms_of_a_file_are_the_same_in_the_planes_of_pitch_and_yaw(jobs):
    """A body of revolution may be turned by a quarter about its axis: the wrench turns with its motion."""
    job = jobs["dragged"]
    products = fit_products(job, make_link(job))
    assert np.abs(products[:, [2, 4]]).max() > 0
    turn = np.kron(np.eye(2), [[1, 0, 0], [0, 0, -1], [0, 1, 0]])

    def find_wrench(nu):
        """The sum of [0, i, j, k] nu_j |nu_k| + [1, i, j, k] nu_j nu_k."""
        return np.einsum("ijk,j,k", products[0], nu, abs(nu)) + np.einsum("ijk,j,k", products[1], nu, nu)

    for nu in np.random.default_rng(1).normal(size=(20, 6)) * [1, 0, 1, 0, 9, 0]:
        assert find_wrench(turn @ nu) == pytest.approx(turn @ find_wrench(nu), rel=1e-9, abs=1e-12)


def test_the_speed_of_reference_is_that_of_rising_and_never_nothing(cylinder):
    fluid = Fluid()
    net = (fluid.density * cylinder.mass.volume - cylinder.mass.mass) * fluid.gravity
    _, across = terminal_speeds(cylinder.coefficients.drag, net, True, fluid.density, fluid.viscosity)
    assert reference_speed(cylinder, fluid) == across > MIN_SPEED
    neutral = replace(cylinder, mass=replace(cylinder.mass, mass=fluid.density * cylinder.mass.volume))
    assert reference_speed(neutral, fluid) == MIN_SPEED
