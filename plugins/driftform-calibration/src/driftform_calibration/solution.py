"""Solve the least-squares problem of a calibration: a start, the best fit, its noise, its covariance, and lost frames."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_calibration.problem import RELEASE_ANGLE, Anchor, Problem
from driftform_calibration.tracks import has_even_times

ROBUST = 3.0
"""Residual over noise from which a point counts less."""

EVALUATIONS = 40
"""Most steps of a fit."""

DELAYS = 120
"""Times of release that are tried before the first point of a track, and after it."""

STUCK = 1.5
"""Residuals of a track over its noise above which a fit is tried again from elsewhere."""

ASIDE = 0.6
"""Distance of another start from the expected value of a factor, over its standard deviation."""

TOLERANCE, ROUGH = 1e-5, 1e-3
"""Relative tolerances of a fit, and of one that only shows where another may begin."""

RELEASE_PITCHES = (0.0, -RELEASE_ANGLE, RELEASE_ANGLE)
"""Errors of the pitch of a release from which the fit of a track begins that is far off, rad."""

ENOUGH = 0.99
"""Share of the cost of a fit below which another one is better."""

ROUNDS, STEADY = 3, 0.05
"""Most fits in which the noise becomes that of the residuals, and its logarithmic change that does not matter."""


CLEAR = 4.5
"""Step over its standard error from which frames were lost: of fits of three films of 100 points, one in 1000 has it by chance."""

MIN_BESIDE = 2
"""Points before the first place of a step, and after the last."""


@dataclass(frozen=True, eq=False)
class Solution:
    """The best fit of a problem: the unknowns ``x`` (parameters,), and their covariance (parameters, parameters)."""

    problem: Problem
    x: FloatArray
    covariance: FloatArray

    def anchor(self) -> Anchor:
        """Return it as what is known before another fit of the same unknowns."""
        keys = [(p.owner, p.name) for p in self.problem.parameters]
        values, vectors = np.linalg.eigh(self.covariance)
        rows = (vectors / np.sqrt(np.maximum(values, 1e-18 * values.max()))).T
        return Anchor(keys, self.x, rows, [float(film.track.t[-1]) for film in self.problem.films])


def solve_problem(problem: Problem, x: FloatArray, is_near: bool = False) -> Solution:
    """Return the best fit from a start that may be far from it; if it ``is_near``, no other start is tried.

    The noise sets the weight of the tracks against what is known of releases and cameras: it becomes that of the residuals.
    """
    x = _approach(problem, x) if is_near else _approach_from_several(problem, x)
    for _ in range(ROUNDS):
        scales = [_spread(residuals, lost) for residuals, lost in _list_residuals(problem, x)]
        if max(abs(np.log(scales))) < STEADY:
            break
        problem = problem.with_noise([n * s for n, s in zip(problem.noise, scales, strict=True)])
        x = find_best(problem, x)
    return Solution(problem, x, estimate_covariance(problem, x))


def merge_solutions(solutions: Sequence[Solution]) -> Solution:
    """Return the best of several solutions of a problem; those that fit nearly as well widen its covariance.

    After a bounce, quite different coefficients may show the same flight. With normal distributions about each solution,
    the variance about the best one grows by the squares of the distances, weighted by the likelihoods. As in
    :func:`estimate_covariance`, correlated residuals count less.
    """
    noise = solutions[0].problem.noise
    common = [(_measure_cost(s.problem.with_noise(noise), s.x), s) for s in solutions]
    least, best = min(common, key=lambda pair: pair[0])
    covariance = best.covariance.copy()
    time = np.mean([correlation_time(best.problem, best.x, k) for k in range(len(best.problem.films))])
    for cost, other in common:
        away = other.x - best.x
        covariance += np.exp((least - cost) / (2 * time)) * np.outer(away, away)
    return replace(best, covariance=covariance)


def _approach(problem: Problem, x: FloatArray, tolerance: float = TOLERANCE) -> FloatArray:
    """Return the unknowns that fit best, from a start that may be far from them.

    The first fits take the noise to be as large as the residuals: they follow the tracks roughly, and stay near what is
    known before. A fit with the true noise from the start would end in the next hollow.
    """
    worst = max(float(np.sqrt(np.mean(r**2))) for r in _split(problem, problem.residuals(x)))
    for share in (1.0, 0.5):
        if worst > 3.0:
            rough = problem.with_noise([n * worst**share for n in problem.noise])
            x = find_best(rough, x, tolerance=ROUGH)
    return find_best(problem, x, tolerance=tolerance)


def _approach_from_several(problem: Problem, x: FloatArray) -> FloatArray:
    """Return the unknowns that fit best; from other starts too while a track is far off.

    A release that was placed a second too early, or a hull that is far lighter than the model's, are hollows of their own.
    """
    best = _free_tracks(problem, _approach(problem, x))
    # Releases and cameras as expected, and each factor in turn aside from what is expected.
    factors = [name for name in ("hull_density", "cross_drag", "axial_drag") if name in problem.names]
    for name, aside in product(factors, (ASIDE, -ASIDE)):
        if not _list_stuck(problem, best):
            break
        start, j = problem.start.copy(), problem.names.index(name)
        start[j] = np.clip(start[j] + aside * problem.parameters[j].prior, problem.low[j], problem.high[j])
        trial = _approach(problem, place_releases(problem, start), ROUGH)
        if _measure_cost(problem, trial) < ENOUGH * _measure_cost(problem, best):
            best = _free_tracks(problem, find_best(problem, trial))
    return best


def _free_tracks(problem: Problem, x: FloatArray) -> FloatArray:
    """Return the unknowns with the releases and cameras of tracks that are far off found anew, while that helps."""
    while stuck := _list_stuck(problem, x):
        trial = x.copy()
        for j, parameter in enumerate(problem.parameters):
            if parameter.owner in stuck:
                trial[j] = problem.start[j]
        trial = _approach(problem, place_releases(problem, trial, stuck, RELEASE_PITCHES), ROUGH)
        if _measure_cost(problem, trial) >= ENOUGH * _measure_cost(problem, x):
            break
        x = find_best(problem, trial)
    return x


def _list_stuck(problem: Problem, x: FloatArray) -> list[int]:
    """Return the numbers of the tracks that are far off."""
    return [k for k, r in enumerate(_split(problem, problem.residuals(x))) if _spread(r) >= STUCK]


def _measure_cost(problem: Problem, x: FloatArray) -> float:
    """Return what a fit minimises: soft for data, quadratic for priors."""
    residuals, data = problem.residuals(x), sum(problem.counts)
    soft = 2 * ROBUST**2 * (np.sqrt(1 + (residuals[:data] / ROBUST) ** 2) - 1)
    return float(soft.sum() + (residuals[data:] ** 2).sum())


def place_releases(
    problem: Problem, x: FloatArray, tracks: Sequence[int] | None = None, pitches: Sequence[float] = (0.0,)
) -> FloatArray:
    """Return the unknowns with the time of each release at which the flight comes nearest to its track.

    Args:
        tracks: whose releases are placed; by default all.
        pitches: errors of the pitch of a release (rad) that are tried: an agent that is released level may tip to either
            side.
    """
    x = x.copy()
    index = {(p.owner, p.name): j for j, p in enumerate(problem.parameters)}
    for number in range(len(problem.films)) if tracks is None else tracks:
        film = problem.films[number]
        j = index[number, "delay"]
        p, t = problem.parameters[j], film.track.t
        last = float(t[-1] - t[0])
        candidates = [
            float(t[0]),
            *np.linspace(p.low, float(t[0]), DELAYS),
            *np.linspace(float(t[0]), float(t[0]) + 0.9 * last, DELAYS),
        ]
        best, expected = np.inf, x.copy()
        for pitch in pitches:
            early = expected.copy()
            early[j] = p.low
            early[index[number, "pitch"]] += pitch
            path = problem.fly(early, number)
            for delay in candidates:
                trial = early.copy()
                trial[j] = delay
                off = film.track.points - problem.see(trial, number, path)
                # Squares: an agent that lies on the floor for most of the film must not decide.
                means = (np.nanmean(off[..., k]) if seen else 0.0 for k, seen in enumerate(film.seen_axes))
                shift = np.array(list(means))
                cost = float(np.sqrt(np.nanmean((off - shift) ** 2)))
                if cost < 0.98 * best:
                    best, x = cost, trial
                    for axis in np.flatnonzero(film.seen_axes):
                        x[index[number, f"offset {axis}"]] = shift[axis]
    return x


def find_best(
    problem: Problem, x: FloatArray, free: Sequence[int] | None = None, tolerance: float = TOLERANCE
) -> FloatArray:
    """Return the unknowns that fit best; only those at the places ``free`` change."""
    from scipy.optimize import least_squares

    places = np.arange(len(x)) if free is None else np.asarray(free, dtype=int)
    data = sum(problem.counts)

    def fill(part: FloatArray) -> FloatArray:
        full = x.copy()
        full[places] = part
        return full

    def loss(z: FloatArray) -> FloatArray:
        """Soft for data, quadratic for priors; value, and first and second derivative, (3, residuals)."""
        root = np.sqrt(1 + z)
        out = np.array([2 * (root - 1), 1 / root, -0.5 / root**3])
        out[:, data:] = [z[data:], np.ones_like(z[data:]), np.zeros_like(z[data:])]
        return out

    low, high = problem.low[places], problem.high[places]
    room = 1e-9 * np.maximum(1.0, np.abs(x[places]))
    try:
        found = least_squares(
            lambda part: problem.residuals(fill(part)),
            np.clip(x[places], low + room, high - room),
            jac=lambda part: problem.jacobian(fill(part))[:, places],
            bounds=(low, high),
            x_scale="jac",
            loss=loss,
            f_scale=ROBUST,
            xtol=tolerance,
            ftol=tolerance,
            gtol=tolerance,
            max_nfev=EVALUATIONS,
        )
    except ValueError:
        raise WorkFailedError("a flight of the fit is not finite; the tracks cannot be those of this agent") from None
    return fill(np.asarray(found.x))


def _split(problem: Problem, rows: FloatArray) -> list[FloatArray]:
    """Return the residuals of each track, or their derivatives."""
    return np.split(rows[: sum(problem.counts)], np.cumsum(problem.counts)[:-1])


def _spread(residuals: FloatArray, lost: float = 0.0) -> float:
    """Return the standard deviation of residuals that the soft loss has fitted (Huber 1964), of which ``lost`` are used up."""
    slope = float(np.mean((1 + (residuals / ROBUST) ** 2) ** -1.5))
    return float(np.sqrt((soften(residuals) ** 2).sum() / max(1.0, len(residuals) - lost)) / slope)


def soften(residuals: FloatArray) -> FloatArray:
    """Return what residuals count by the soft loss: themselves if they are small, at most :data:`ROBUST`."""
    return np.asarray(residuals / np.sqrt(1 + (residuals / ROBUST) ** 2))


def _list_residuals(problem: Problem, x: FloatArray) -> list[tuple[FloatArray, float]]:
    """Return the residuals of each track, and how many of them its unknowns have used up."""
    found, known = [], problem.prior_rows.T @ problem.prior_rows
    blocks, rows = (_split(problem, values) for values in (problem.jacobian(x), problem.residuals(x)))
    for block, residuals in zip(blocks, rows, strict=True):
        plain = block.T @ block
        lost = float(np.trace(plain @ np.linalg.pinv(plain + known, hermitian=True)))
        found.append((residuals, min(lost, 0.5 * len(residuals))))
    return found


def estimate_covariance(problem: Problem, x: FloatArray) -> FloatArray:
    """Return the covariance of the unknowns, (parameters, parameters).

    Residuals of each track have the variance s^2, and along the track the integrated autocorrelation time tau: the track
    counts as if it had 1 / tau as many points. What was known before adds its own information, and the points that an
    earlier fit has counted add none.
    """
    information = problem.prior_rows.T @ problem.prior_rows
    tracks = zip(_split(problem, problem.jacobian(x)), _list_residuals(problem, x), strict=True)
    for number, (block, (residuals, lost)) in enumerate(tracks):
        spread, tau = _spread(residuals, lost), correlation_time(problem, x, number)
        new = block[problem.list_new(number)]
        information = information + new.T @ new / (spread**2 * tau)
    return np.asarray(np.linalg.pinv(information, hermitian=True))


def correlation_time(problem: Problem, x: FloatArray, number: int) -> float:
    """Return the integrated autocorrelation time of a track's residuals, in points, at least 1."""
    film = problem.films[number]
    return measure_correlation(problem.see(x, number, problem.paths(x)[number]) - film.track.points)


def measure_correlation(off: FloatArray) -> float:
    """Return the integrated autocorrelation time of differences (markers, n, d), NaN where not seen, in points, at least 1.

    1 + 2 sum of the autocorrelations, up to the first that is not above its noise (Sokal 1997, Monte Carlo methods in
    statistical mechanics, section 3, with a simpler end).
    """
    products = np.zeros(off.shape[1])
    from scipy.signal import correlate

    for series in np.moveaxis(off, 1, 2).reshape(-1, off.shape[1]):
        seen = series[np.isfinite(series)]
        if len(seen) >= 8:
            limit = 3 * 1.4826 * np.median(np.abs(seen)) + 1e-300
            seen = np.clip(seen, -limit, limit)
            full = correlate(seen, seen, method="fft")[len(seen) - 1 :]
            products[: len(full)] += full
    if products[0] <= 0:
        return 1.0
    rho, tau = products / products[0], 1.0
    for lag in range(1, max(2, len(rho) // 3)):
        if rho[lag] < 2 / np.sqrt(len(rho)):
            break
        tau += 2 * float(rho[lag])
    return tau


def find_lost_frames(solution: Solution) -> tuple[str, float] | None:
    """Return the name of the first track that lost frames, and the time (s) of the point after them; ``None`` without one.

    A step ahead in time at each point of a track is compared with the residuals, after the unknowns of the fit have
    taken their part of both (the score test: Rao 1948, Proc. Camb. Phil. Soc. 44, 50). The residuals that the step
    leaves count as in :func:`estimate_covariance`: an error of the model, which makes
    neighbouring residuals alike, is not a step.
    """
    problem, x = solution.problem, solution.x
    jacobian, residuals = problem.jacobian(x), soften(problem.residuals(x))
    basis, sizes, _ = np.linalg.svd(jacobian, full_matrices=False)
    basis = basis[:, sizes > 1e-10 * sizes[0]]
    rest = residuals - basis @ (basis.T @ residuals)
    ends = np.cumsum(problem.counts)
    for number, (film, end, count) in enumerate(zip(problem.films, ends, problem.counts, strict=True)):
        steps = np.diff(film.track.t)
        if len(steps) < 2 * MIN_BESIDE or not has_even_times(film.track):
            continue
        [delay] = (j for j, p in enumerate(problem.parameters) if (p.owner, p.name) == (number, "delay"))
        rows = slice(end - count, end)
        places = np.arange(MIN_BESIDE, len(steps) + 1 - MIN_BESIDE)
        # A track that is ahead by a frame fits a flight that began a frame earlier.
        late = jacobian[rows, delay] * float(np.median(steps))
        shifts = np.zeros((len(rest), len(places)))
        shifts[rows] = late[:, None] * (film.times[:, None] >= film.track.t[places])
        shifts -= basis @ (basis.T @ shifts)
        energy = np.maximum((shifts**2).sum(axis=0), 1e-12)
        frames = rest @ shifts / energy
        best = int(np.argmax(frames * np.sqrt(energy)))
        left = rest[rows] - frames[best] * shifts[rows, best]
        # Residuals of points in the shape of the points.
        off, seen = np.full(film.track.points.shape, np.nan), ~np.isnan(film.track.points)
        off[seen] = left[: int(seen.sum())]
        deviation = np.sqrt(np.mean(left**2) * measure_correlation(off))
        if frames[best] > 0.5 and frames[best] * np.sqrt(energy[best]) > CLEAR * deviation:
            return film.track.name, float(film.track.t[places[best]])
    return None
