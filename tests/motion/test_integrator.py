"""The integrator: its coefficients, its order, and whether its estimate of the error can be trusted."""

import math

import numpy as np
import pytest
from closed_forms import Libration
from scipy.integrate import DOP853 as SCIPY_DOP853
from scipy.integrate import RK45 as SCIPY_RK45
from scipy.stats import binom

from driftform.motion.forces.model import flight_model
from driftform.motion.forces.state import release_state
from driftform.motion.solver.error import (
    LEAST_ERROR,
    SAFETY_FACTOR,
    TOLERANCE_RATIO,
    Accuracy,
    greatest_distance,
    integrate,
    tighten,
)
from driftform.motion.solver.tableaus import DOP853, DOPRI5
from driftform.study import load_study
from driftform.testing.agents import Spheroid, sphere_agent, tumbling_agent
from driftform.testing.simulator import water_scenario

SPHEROID = Spheroid(0.06, 0.01)
SAMPLE = 14


@pytest.mark.parametrize(("pair", "known"), [(DOPRI5, SCIPY_RK45), (DOP853, SCIPY_DOP853)])
def test_the_coefficients_are_those_that_scipy_has(pair, known):
    stages = known.n_stages
    assert pair.a.shape == (stages, stages)
    columns = min(stages, known.A.shape[1])
    assert pair.a[:, :columns] == pytest.approx(known.A[:stages, :columns], rel=1e-15, abs=1e-16)
    assert not pair.a[:, columns:].any()
    assert pair.b == pytest.approx(known.B, rel=1e-15, abs=1e-16)
    assert pair.c == pytest.approx(known.C[:stages], rel=1e-15, abs=1e-16)
    assert pair.power == known.error_estimator_order + 1
    if pair is DOPRI5:
        # The sign of an error does not matter.
        assert np.abs(pair.error) == pytest.approx(np.abs(known.E), rel=1e-12, abs=1e-16)
        assert not pair.second.any()
    else:
        assert np.abs(pair.error) == pytest.approx(np.abs(known.E5), rel=1e-12, abs=1e-16)
        assert np.abs(pair.second) == pytest.approx(np.abs(known.E3), rel=1e-12, abs=1e-16)


def libration(pair, horizon):
    """A smooth flight of known motion that is integrated by one of the pairs alone."""
    scenario = water_scenario(horizon, (1.0, 0.01, 0.0), pipe=(50.0, 10.0))
    model = flight_model(SPHEROID.agent(), scenario)
    if pair is DOPRI5:
        # A body that could reach the wall from anywhere is integrated as near to it; without surfaces it never touches.
        numbers = model.numbers.copy()
        numbers["reach"] = 1e9
        model = model._replace(numbers=numbers, surfaces=np.empty((0, 7)))
    return model, release_state(model, scenario)


def yaw_error(pair, horizon=1.0, **accuracy):
    """Largest error of the yaw rate, relative to the largest rate."""
    motion = Libration(SPHEROID, 1.0, 0.01)
    samples = integrate(*libration(pair, horizon), horizon, Accuracy(position=math.inf, **accuracy)).samples
    assert samples[-1, 0] == horizon
    exact = motion.motion_at(samples[:, 0])[:, 2]
    return np.abs(samples[:, 13] - exact).max() / motion.max_yaw_rate


@pytest.mark.parametrize(("pair", "step", "order"), [(DOPRI5, 0.002, 5), (DOP853, 0.016, 8)])
def test_the_error_falls_with_the_step_as_the_pairs_order_says(pair, step, order):
    # With a tolerance that accepts everything, steps are as long as they may be.
    coarse, fine = (yaw_error(pair, tolerance=1e9, max_step=h) for h in (step, step / 2))
    # The order is a bound: a motion to and fro lets some of the error cancel, of DOP853's nearly a whole order.
    assert order - 0.1 < math.log2(coarse / fine) < order + 1.1
    assert fine > 1e-13, "it is rounding"


@pytest.mark.parametrize("pair", [DOPRI5, DOP853])
def test_the_error_falls_in_proportion_to_the_tolerance(pair):
    tolerances = 10.0 ** -np.arange(3, 10)
    errors = [yaw_error(pair, tolerance=t, tightest=1e-12, max_step=1.0) for t in tolerances]
    slope = np.polyfit(np.log10(tolerances), np.log10(errors), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.15)
    assert errors[-1] < 1e-6


FLIGHTS = 400


def fewest(share):
    """Return the fewest of ``FLIGHTS`` that have what a ``share`` of all have; fewer come once in a million samples."""
    return binom.ppf(1e-6, FLIGHTS, share)


@pytest.fixture(scope="module")
def default_flights():
    """Estimated error of agents of the default study, and bounds of their true one, m."""
    pipeline = load_study(run={"seed": 1}).make_pipeline()
    rng = np.random.default_rng(20)
    horizon, errors = pipeline.scenario.flight.horizon, []
    exact = Accuracy(position=math.inf, tolerance=1e-12, tightest=1e-13, max_step=0.005, step_limit=2_000_000)
    for _ in range(FLIGHTS):
        model = flight_model(pipeline.make_agent(pipeline.grammar.random(rng)), pipeline.scenario)
        start = release_state(model, pipeline.scenario)
        flown = integrate(model, start, horizon, Accuracy())
        truth = integrate(model, start, horizon, exact)
        distance = greatest_distance(truth.samples, flown.samples)
        # What is stated at least is for steps ten times as long.
        doubt = truth.error if truth.error > LEAST_ERROR else 0.0
        errors.append((flown.error, distance - doubt, distance + doubt))
    return np.array(errors).T


@pytest.mark.long
def test_the_estimated_error_covers_the_true_one(default_flights):
    # The shares are those that SAFETY_FACTOR's docstring states of 2000 agents, rounded down.
    estimated, least, most = default_flights
    # A few flights bounce so chaotically that no tolerance helps: they say so.
    sure = estimated <= Accuracy().position
    assert sure.sum() >= fewest(0.99)
    estimated, least, most = estimated[sure], least[sure], most[sure]
    assert (estimated >= most).sum() >= fewest(0.98)
    # Where it is more than the least error that is stated, it is within two orders of magnitude for nearly all.
    assert (estimated <= np.maximum(100 * least, LEAST_ERROR)).sum() >= fewest(0.85)
    # An error in proportion to the tolerance is a ninth of the distance of which the estimate is twice as much.
    expected = SAFETY_FACTOR * (TOLERANCE_RATIO - 1)
    assert (estimated >= expected / 3 * most).sum() >= fewest(0.5)
    assert (estimated <= np.maximum(expected * 3 * least, LEAST_ERROR)).sum() >= fewest(0.5)
    # What is asked for is what is got: a millimetre, or where the estimate was unlucky a little more.
    assert (most < Accuracy().position).sum() >= fewest(0.99)
    # Such a flight may have no exact end to compare with either.
    assert np.isfinite(most).sum() >= fewest(0.99)
    assert most[np.isfinite(most)].max() < 10 * Accuracy().position


@pytest.mark.parametrize(
    ("height", "offsets", "tolerance", "stated"),
    [
        # Clear of the wall, one comparison accepts: twice the distance.
        (0.0, [math.nan, 1e-4, 0.0], 1e-6, 2e-4),
        # No comparison shows less than the least error.
        (0.0, [math.nan, 1e-5, 0.0], 1e-6, LEAST_ERROR),
        # The error falls from 20 mm by no more than a tenth a tolerance, and what is stated by no more than a fifth.
        (0.0, [math.nan, 0.0, 2e-2, 2e-2, 2e-2], 1e-8, 1e-3),
        (0.0, [math.nan, 0.0, 6e-4, 6e-4, 6e-4], 1e-7, 2 * 6e-4 / 5),
        # At the wall, two integrations that agree are compared with a third.
        (0.19, [1e-3, 0.0, 0.0], 1e-6, 3 * 1e-3 / 5),
        (0.19, [1e-2, 0.0, 0.0, 0.0], 1e-7, 1e-3),
        (0.19, [0.0, 0.0, 0.0], 1e-6, LEAST_ERROR),
    ],
)
def test_integrations_that_agree_by_chance_do_not_state_so(height, offsets, tolerance, stated):
    model = flight_model(sphere_agent(0.02, 0.1), water_scenario(1.0, pipe=(9.0, 0.2)))
    tolerances = []

    def fly(at):
        """A straight path whose error depends on its tolerance."""
        tolerances.append(at)
        samples = np.zeros((11, SAMPLE))
        samples[:, 0], samples[:, 4] = np.linspace(0, 1, 11), 1.0
        samples[:, 1], samples[:, 8] = samples[:, 0], 1.0
        samples[:, 3] = height + offsets[round(-math.log10(at)) - 4]
        return samples

    flown = tighten(fly, fly(1e-5), model, Accuracy())
    assert flown.tolerance == pytest.approx(tolerance)
    assert flown.error == pytest.approx(stated, rel=1e-6)
    # Only where it accepts is a third integration worth its time.
    assert (np.max(tolerances) > 2e-5) == (height > 0)


def test_a_flight_is_repeated_until_it_is_accurate_enough():
    scenario = water_scenario(4.0, speed=1.0, pipe=(9.0, 0.3))
    model = flight_model(tumbling_agent(), scenario)
    start = release_state(model, scenario)
    for accepted in (1e-2, 1e-4, 1e-5):
        flown = integrate(model, start, 4.0, Accuracy(position=accepted, tolerance=1e-4))
        assert flown.error <= accepted
        assert flown.tolerance <= 1e-4
    hopeless = integrate(model, start, 4.0, Accuracy(position=1e-15, tolerance=1e-4, tightest=1e-6))
    assert hopeless.error > 1e-15
    assert 0.9e-6 < hopeless.tolerance < 1e-5, "it stops at the tightest tolerance"


def test_steps_end_at_the_horizon_and_are_never_longer_than_allowed():
    model, start = libration(DOP853, 0.7)
    samples = integrate(model, start, 0.7, Accuracy(max_step=0.02)).samples
    assert samples[0] == pytest.approx([0.0, *start])
    assert samples[-1, 0] == 0.7
    steps = np.diff(samples[:, 0])
    assert (steps > 0).all()
    assert steps.max() <= 0.02 * (1 + 1e-12)
    assert np.linalg.norm(samples[:, 4:8], axis=1) == pytest.approx(np.ones(len(samples)), abs=1e-12)


def test_a_flight_out_of_steps_stops_and_one_that_is_not_finite_says_so():
    model, start = libration(DOP853, 1.0)
    short = integrate(model, start, 1.0, Accuracy(max_step=0.001, step_limit=50))
    assert len(short.samples) == 51
    broken = integrate(model, np.where(np.arange(13) == 8, np.nan, start), 1.0, Accuracy())
    assert broken.error == math.inf
    assert not np.isfinite(broken.samples[-1]).all()


@pytest.mark.parametrize("broken", [True, False])
def test_a_flight_that_fails_twice_alike_is_not_refined_any_further(broken):
    model, start = libration(DOP853, 1.0)
    start = np.where((np.arange(13) == 8) & broken, np.nan, start)
    # No error is small enough, so that a sound flight would be refined to the end.
    accuracy = Accuracy(position=-1.0, max_step=0.001, step_limit=50, tolerance=1e-6, tightest=1e-12)
    assert integrate(model, start, 1.0, accuracy).tolerance == accuracy.tolerance


# How far apart two flights get.


def straight(t, velocity=(1.0, 0.2, -0.1), start=(0.0, 0.0, 0.0)):
    t = np.asarray(t, dtype=float)
    samples = np.zeros((len(t), SAMPLE))
    samples[:, 0], samples[:, 4] = t, 1.0
    samples[:, 1:4] = start + np.outer(t, velocity)
    samples[:, 8:11] = velocity
    return samples


def test_a_flight_is_no_way_from_itself_however_it_is_sampled():
    whole, half = straight(np.linspace(0, 2, 21)), straight(np.linspace(0, 2, 14))
    for a, b in ((whole, whole), (whole, half), (half, whole)):
        assert greatest_distance(a, b) == pytest.approx(0, abs=1e-15)


def test_the_path_between_samples_is_the_cubic_through_positions_and_velocities():
    def cubic(t):
        t = np.asarray(t)
        samples = straight(t)
        samples[:, 1:4] = np.column_stack([t**3, 1 - 2 * t**2, 0.5 * t])
        samples[:, 8:11] = np.column_stack([3 * t**2, -4 * t, np.full_like(t, 0.5)])
        return samples

    assert greatest_distance(cubic(np.linspace(0, 2, 4)), cubic(np.linspace(0, 2, 50))) < 1e-14


def test_the_greatest_distance_counts_wherever_it_is():
    times = np.linspace(0, 2, 21)
    aside = straight(times, start=(0.3, 0.0, -0.4))
    assert greatest_distance(straight(times), aside) == pytest.approx(0.5, rel=1e-12)
    faster = straight(times, velocity=(1.1, 0.2, -0.1))
    assert greatest_distance(straight(times), faster) == pytest.approx(0.2, rel=1e-9)
    bump = straight(times)
    bump[7, 2] += 0.01
    assert greatest_distance(straight(times), bump) == pytest.approx(0.01, rel=1e-9)


def test_flights_that_do_not_end_alike_are_infinitely_far_apart():
    times = np.linspace(0, 2, 21)
    longer, step = straight(np.linspace(0, 2.5, 26)), straight(np.linspace(0, 2.08, 27))
    for a, b in ((straight(times), longer), (longer, straight(times))):
        assert greatest_distance(a, b) == math.inf
    # Up to a step may lie between their last samples, past the outlet.
    for a, b in ((straight(times), step), (step, straight(times))):
        assert greatest_distance(a, b) < 1e-15
    broken = straight(times)
    broken[-1, 5] = np.nan
    for a, b in ((straight(times), broken), (broken, straight(times))):
        assert greatest_distance(a, b) == greatest_distance(a, b, False) == math.inf


def test_flights_in_gusts_that_arrive_at_different_times_are_as_far_apart_as_up_to_the_first_arrival():
    early, late = straight(np.linspace(0, 2, 21)), straight(np.linspace(0, 2.2, 26), velocity=(0.9, 0.2, -0.1))
    assert greatest_distance(early, late) == math.inf
    # The later flight is sampled at 1.936 s, and then at 2.024 s.
    assert greatest_distance(early, late, False) == pytest.approx(0.1936, rel=1e-9)
    assert greatest_distance(late, early, False) == pytest.approx(0.2, rel=1e-9)


def test_a_flight_released_at_the_outlet_is_over_at_once_and_has_no_error():
    scenario = water_scenario(4.0, position=(9.0, 0.0, 0.0), pipe=(9.0, 1.0))
    model = flight_model(tumbling_agent(), scenario)
    flown = integrate(model, release_state(model, scenario), 4.0, Accuracy())
    assert (len(flown.samples), flown.error) == (1, 0.0)
