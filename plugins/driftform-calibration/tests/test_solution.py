"""The covariance of a fit, against linear least squares in closed form and against the scatter of repeated films; intervals."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from driftform_calibration.bench import Bench
from driftform_calibration.experiment import _choose
from driftform_calibration.fit import _find_interval
from driftform_calibration.problem import PRIOR, Parameter
from driftform_calibration.protocol import Drop
from driftform_calibration.solution import (
    ROBUST,
    Solution,
    _spread,
    correlation_time,
    estimate_covariance,
    merge_solutions,
)
from driftform_calibration.tracks import Track


class Lines:
    """A problem whose films show u = a + b t, one coordinate each: least squares in closed form.

    The unknowns are a and b; each film may have its own noise, by which residuals are divided. An earlier fit has counted
    the first ``early`` points of each film.
    """

    names = ("cross_drag", "axial_drag")

    def __init__(self, seen, noise, prior_rows=None, t=None, early=0):
        self.early = early
        self.noise, self.seen = tuple(noise), list(seen)
        self.prior_rows = np.zeros((0, 2)) if prior_rows is None else prior_rows
        times = [np.linspace(-1, 1, len(u)) if t is None else t for u in seen]
        self.designs = [np.column_stack([np.ones_like(time), time]) for time in times]
        tracks = [Track("", time, u[None, :, None]) for u, time in zip(seen, times, strict=True)]
        self.films = [SimpleNamespace(track=track) for track in tracks]
        self.counts = [int(np.isfinite(u).sum()) for u in seen]
        self.parameters = [Parameter(-1, name, 0.0, -9.0, 9.0, np.inf) for name in "ab"]

    def with_noise(self, noise):
        return Lines(self.seen, noise, self.prior_rows)

    def paths(self, x):
        return [None] * len(self.films)

    def see(self, x, number, path=None):
        return (self.designs[number] @ x)[None, :, None]

    def residuals(self, x):
        parts = [((A @ x - u) / s)[np.isfinite(u)] for A, u, s in zip(self.designs, self.seen, self.noise, strict=True)]
        return np.concatenate([*parts, self.prior_rows @ x])

    def jacobian(self, x):
        parts = [A[np.isfinite(u)] / s for A, u, s in zip(self.designs, self.seen, self.noise, strict=True)]
        return np.vstack([*parts, self.prior_rows])

    def list_new(self, number):
        return np.flatnonzero(np.isfinite(self.seen[number])) >= self.early

    def solve(self):
        return np.linalg.lstsq(self.jacobian(np.zeros(2)), -self.residuals(np.zeros(2)), rcond=None)[0]


def draw_series(rng, count, rho, size=1.0):
    """Noise of an autoregression with the correlation ``rho`` of neighbours, from its stationary distribution."""
    out = np.empty(count)
    out[0] = rng.normal()
    steps = np.sqrt(1 - rho**2) * rng.normal(size=count)
    for k in range(1, count):
        out[k] = rho * out[k - 1] + steps[k]
    return size * out


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_the_covariance_is_the_scatter_of_fits_to_films_whose_errors_are_correlated(rho):
    """A point that errs as its neighbour does counts less: by (1 + rho) / (1 - rho) in the variance."""
    rng, truth = np.random.default_rng(1), np.array([0.3, -0.2])
    fits, covariances = [], []
    for _ in range(150):
        lines = Lines([np.zeros(1000)], [0.01])
        lines = Lines([lines.designs[0] @ truth + draw_series(rng, 1000, rho, 0.01)], [0.01])
        fits.append(lines.solve())
        covariances.append(estimate_covariance(lines, fits[-1]))
    scatter, expected = np.cov(np.array(fits).T), np.mean(covariances, axis=0)
    assert np.diag(expected) == pytest.approx(np.diag(scatter), rel=0.35)
    white = 0.01**2 * np.linalg.inv(lines.designs[0].T @ lines.designs[0])
    assert np.diag(expected) == pytest.approx(np.diag(white) * (1 + rho) / (1 - rho), rel=0.25)


def test_the_covariance_of_white_residuals_is_that_of_the_normal_equations():
    """s^2 (A' A)^-1 with s^2 from n - 2 degrees of freedom; the noise that was assumed cancels while all points count."""
    rng = np.random.default_rng(2)
    u = 0.02 * rng.choice([-1.0, 1.0], 400)
    for assumed in (0.2, 2.0):
        lines = Lines([u], [assumed])
        x, A = lines.solve(), lines.designs[0]
        assert correlation_time(lines, x, 0) == 1.0
        variance = float(((A @ x - u) ** 2).sum()) / 398
        found = estimate_covariance(lines, x)
        assert found == pytest.approx(variance * np.linalg.inv(A.T @ A), rel=4e-3, abs=1e-12)


def test_nine_of_ten_intervals_of_films_with_six_points_hold_the_truth():
    """Two unknowns leave four degrees of freedom: the normal distribution, or six of them, would hold 83 or 88 % (Student 1908)."""
    held = []
    for u in np.random.default_rng(9).normal(size=(5000, 6)):
        lines = Lines([u], [100.0])
        x = lines.solve()
        covariance = estimate_covariance(lines, x)
        low, _, high = _find_interval(Solution(lines, x, covariance), 1, x, np.sqrt(np.diag(covariance)))
        # The factor of the true slope, 0.
        held.append(low < 1.0 < high)
    assert np.mean(held) == pytest.approx(0.9, abs=0.01)


def test_a_drop_that_shows_nothing_is_expected_to_leave_what_is_known_before(design):
    bench = Bench.of(design.pipeline, design.agent.morphology)
    drop = Drop(bench.scenario, 1.0, "time", 0.0, np.zeros((2, 2)))
    _, expected = _choose([(drop, np.zeros((1, 1)))], ("cross_drag",), bench, 1)
    # A factor is exp(w): half of its interval from exp(-w) to exp(w) is sinh(w), and nine of ten normal errors are below w.
    assert math.erf(math.asinh(expected["cross_drag"][0]) / (math.sqrt(2) * PRIOR)) == pytest.approx(0.9)


def test_what_is_known_before_and_every_film_add_their_information():
    rng = np.random.default_rng(3)
    sizes, known = (0.003, 0.001), np.array([[1 / 2e-4, 0.0], [1 / 3e-4, 1 / 3e-4]])
    seen = [size * rng.choice([-1.0, 1.0], count) for size, count in zip(sizes, (200, 300), strict=True)]
    # Noise far above the residuals: every point counts fully.
    lines = Lines(seen, [100 * size for size in sizes], known)
    x = np.zeros(2)
    information = known.T @ known
    for A, size in zip(lines.designs, sizes, strict=True):
        information = information + A.T @ A / size**2
    found = estimate_covariance(lines, x)
    assert found == pytest.approx(np.linalg.inv(information), rel=0.03, abs=1e-12)
    alone = estimate_covariance(Lines(seen[:1], [0.3], known), x)
    assert np.all(np.diag(found) < np.diag(alone))


@pytest.mark.parametrize("rho", [0.3, 0.5, 0.8])
def test_the_correlation_time_of_an_autoregression_is_its_closed_form(rho):
    lines = Lines([draw_series(np.random.default_rng(4), 20_000, rho)], [1.0])
    found = correlation_time(lines, np.zeros(2), 0)
    # Points beyond 4.4 standard deviations of noise are cut, which changes little.
    assert found == pytest.approx((1 + rho) / (1 - rho), rel=0.08)


def test_two_coordinates_share_one_correlation_time():
    rng = np.random.default_rng(5)
    a, b = draw_series(rng, 5000, 0.8), draw_series(rng, 5000, 0.0)
    film = SimpleNamespace(track=Track("", np.arange(5000.0), np.stack([a, b], axis=1)[None]))
    zero = SimpleNamespace(films=[film], see=lambda *_: np.zeros((1, 5000, 2)), paths=lambda _: [None])
    # Both have the variance 1, so that the correlations are means of 0.8^k and 0.
    assert correlation_time(zero, np.zeros(2), 0) == pytest.approx(1 + 0.8 / 0.2, rel=0.15)


def test_a_wild_point_hardly_shortens_the_correlation_time():
    series = draw_series(np.random.default_rng(6), 4000, 0.8)
    series[2000] = 300.0
    assert correlation_time(Lines([series], [1.0]), np.zeros(2), 0) == pytest.approx(9.0, rel=0.15)


def test_the_spread_of_normal_residuals_is_their_standard_deviation():
    residuals = np.random.default_rng(7).normal(size=100_000)
    # Of a soft loss, the spread is that of the estimate: the variance of its influence over the square of its slope.
    assert _spread(residuals) == pytest.approx(1.0, abs=0.02)
    assert _spread(0.01 * residuals) == pytest.approx(0.01, rel=0.01)


def test_the_spread_of_small_residuals_counts_what_the_unknowns_used_up():
    residuals = 1e-4 * np.tile([1.0, -1.0], 50)
    assert _spread(residuals) == pytest.approx(1e-4, rel=1e-6)
    assert _spread(residuals, 36.0) == pytest.approx(1e-4 * 10 / 8, rel=1e-6)
    # No more residuals than unknowns: one degree of freedom is left.
    assert _spread(residuals, 100.0) == pytest.approx(1e-3, rel=1e-6)


def test_a_residual_of_several_times_the_noise_counts_as_its_influence():
    # psi(r) = r / sqrt(1 + (r / c)^2) at r = c is c / sqrt(2), and psi' = 2^-1.5.
    residuals = np.full(4, ROBUST)
    assert _spread(residuals) == pytest.approx(ROBUST / np.sqrt(2) * 2**1.5, rel=1e-12)


def test_a_solution_keeps_its_covariance_as_what_is_known_before_another_fit():
    covariance = np.array([[4e-4, 1e-4], [1e-4, 9e-4]])
    anchor = Solution(Lines([np.zeros(9)], [1.0]), np.array([0.1, 0.2]), covariance).anchor()
    assert list(anchor.keys) == [(-1, "a"), (-1, "b")]
    assert anchor.centre == pytest.approx([0.1, 0.2])
    assert np.linalg.inv(anchor.rows.T @ anchor.rows) == pytest.approx(covariance, rel=1e-9)


def test_points_count_once_where_an_earlier_fit_has_counted_them():
    """What that fit found, and the points that are new to this one, show as much as all points do in one fit."""
    lines = Lines([np.tile([1.0, -1.0], 50)], [1.0])
    design = lines.designs[0]
    known = np.linalg.cholesky(design[:60].T @ design[:60]).T / _spread(lines.residuals(np.zeros(2)), 2.0)
    anchored = Lines(lines.seen, [1.0], known, early=60)
    once, again = (estimate_covariance(problem, np.zeros(2)) for problem in (lines, anchored))
    assert again == pytest.approx(once, rel=0.02, abs=2e-4)


def test_solutions_that_fit_as_well_widen_the_covariance_by_their_distance():
    rng = np.random.default_rng(8)
    lines = Lines([rng.choice([-1.0, 1.0], 200)], [1.0])
    problem, own = lines, np.diag([0.01, 0.02])
    # Of opposite sign, they fit equally to first order; the better one is the sum's centre.
    best = Solution(problem, lines.solve(), own)
    away = np.array([0.02, 0.03])
    other = Solution(problem, best.x + away, np.diag([9.0, 9.0]))
    merged = merge_solutions([other, best])
    assert merged.x is best.x
    soft = [2 * ROBUST**2 * (np.sqrt(1 + (lines.residuals(s.x) / ROBUST) ** 2) - 1).sum() for s in (best, other)]
    weight = np.exp((soft[0] - soft[1]) / 2)
    assert 0.1 < weight < 0.99
    assert merged.covariance == pytest.approx(own + weight * np.outer(away, away), rel=1e-9)
    assert best.covariance is own and own[0, 1] == 0.0, "the best one keeps its own"
