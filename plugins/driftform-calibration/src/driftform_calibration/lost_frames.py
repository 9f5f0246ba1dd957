"""Find frames that were lost and numbered without a gap, by what the best fit leaves: from there on the agent is early."""

import numpy as np

from driftform_calibration.solution import Solution, measure_correlation, soften
from driftform_calibration.tracks import has_even_times

CLEAR = 4.5
"""Step over its standard error from which frames were lost: of fits of three films of 100 points, one in 1000 has it by chance."""

MIN_BESIDE = 2
"""Points before the first place of a step, and after the last."""


def find_lost_frames(solution: Solution) -> tuple[str, float] | None:
    """Return the name of the first track that lost frames, and the time (s) of the point after them; ``None`` without one.

    A step ahead in time at each point of a track is compared with the residuals, after the unknowns of the fit have
    taken their part of both (the score test: Rao 1948, Proc. Camb. Phil. Soc. 44, 50). The residuals that the step
    leaves count as in :func:`driftform_calibration.solution.estimate_covariance`: an error of the model, which makes
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
        off, seen = np.full(film.observed.shape, np.nan), ~np.isnan(film.observed)
        off[seen] = left[: int(seen.sum())]
        deviation = np.sqrt(np.mean(left**2) * measure_correlation(off))
        if frames[best] > 0.5 and frames[best] * np.sqrt(energy[best]) > CLEAR * deviation:
            return film.track.name, float(film.track.t[places[best]])
    return None
