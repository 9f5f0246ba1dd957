"""Fit the factors of a model to films of its flights: values, honest intervals, and what the films do not show.

Robust nonlinear least squares over the factors, the releases and the cameras. The noise is that of the residuals. If
these are correlated along a track, as the errors of a model are, a track shows as much as fewer independent points would.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product

import numpy as np
from threadpoolctl import threadpool_limits

from driftform.types import FloatArray
from driftform.water import Calibration, Factors
from driftform_calibration.bench import Bench, Path
from driftform_calibration.problem import RELEASE_RISE, Filmed, Problem, factor_of, parameter_of, shown_name
from driftform_calibration.solution import (
    Solution,
    find_best,
    find_lost_frames,
    merge_solutions,
    place_releases,
    solve_problem,
)
from driftform_calibration.tracks import estimate_noise

CONFIDENCE = 0.9
"""Probability that an interval holds the factor."""

MAX_WIDTH, MAX_WIDTH_HULL = 0.2, 0.02
"""Widest half of an interval that counts as known, relative to the factor, and of the hull's density: prints are not more exact."""

PLAUSIBLE = {"axial_drag": (0.25, 4.0), "cross_drag": (0.25, 4.0), "added_mass": (0.5, 2.0)}
"""Factors beyond which a model does not err: something else acts on the agent."""

ROUND = 0.9
"""Share of a sphere's drag in that of a body from which the body counts as round."""

ALIKE = 0.8
"""Correlation above which the films cannot separate two factors."""

MIN_NOISE = 1e-3
"""Least noise of a track over its span."""

AFTER_CONTACT = 0.5
"""Time after the first contact that counts, s: a bounce or two. Later, small errors have grown too much."""

SHARES = (0.8, 0.95, 0.98)
"""Shares of the time from the release to the first contact that count as free flight, in fits that follow each other."""

MIN_FREE = 10
"""Fewest points of free flight from which drag and weight are fitted."""

STARTS = (-0.4, 0.0, 0.4)
"""Logarithms of the coefficients of contact from which a fit may begin."""

FILM_NOISE = 2e-3, 1e-4
"""Noise of a film whose points are smoother than any camera sees them: over the span of its track, and m."""

TOO_FAR = 5.0
"""Distance of a track from the calibrated flight over the noise of its points from which no factor is known."""

MAX_DEVIATIONS = 4.0
"""Standard deviations of a release or a camera from what is expected from which no factor is known."""

NEGLIGIBLE = 0.05
"""Correlation that is not worth stating."""

CONTACT = ("restitution", "friction")
"""Factors that only a flight with contact can show."""


@dataclass(frozen=True)
class FactorEstimate:
    """What the films show of a factor.

    Attributes:
        value: the factor; 1 if it is not known.
        low, high: interval that holds it with a probability of 90 %; ``None`` if it is not known.
        known: whether the films show it.
        reason: why they do not, ``""`` if they do.
    """

    value: float = 1.0
    low: float | None = None
    high: float | None = None
    known: bool = False
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Fit:
    """The result of a fit.

    Attributes:
        estimates: of each factor, by the names of :class:`driftform.water.Factors`.
        net_weight: the same for the net weight of the agent, of which its hull's density is the cause.
        residual: root mean square distance of the tracks from the calibrated flights, m.
        before: the same from the flights of the model as it was, with releases and cameras that fit best.
        correlations: between the factors that are known.
        problem, x, x_before: the problem, and its unknowns with the calibrated model and with the model as it was.
        notes: findings of the fit, one line each.
    """

    estimates: dict[str, FactorEstimate]
    net_weight: FactorEstimate
    residual: float
    before: float
    correlations: tuple[tuple[str, str, float], ...]
    problem: Problem
    x: FloatArray
    x_before: FloatArray
    notes: tuple[str, ...] = field(default=())

    @property
    def known(self) -> tuple[str, ...]:
        """Names of the factors that the films show."""
        return tuple(name for name, found in self.estimates.items() if found.known)

    def calibration(self, agent: str = "") -> Calibration:
        """Return the table ``[calibration]`` of the factors that are known."""
        intervals = {
            name: (_round(found.value), _round(found.low), _round(found.high))
            for name, found in self.estimates.items()
            if found.known and found.low is not None and found.high is not None
        }
        about = {"agent": agent, "tracks": len(self.problem.films), "residual": _round(self.residual)}
        return Calibration.model_validate({**intervals, "correlations": self.correlations, **about})


def _round(value: float) -> float:
    return float(f"{value:.4g}")


def fit_factors(
    films: Sequence[Filmed], names: Sequence[str] = Factors.names, priors: dict[str, tuple[float, float]] | None = None
) -> Fit:
    """Fit the factors ``names`` to films; the others stay at 1.

    Args:
        films: of the same agent.
        priors: what is known of a parameter of :class:`driftform_calibration.problem.Problem` before: value and
            standard deviation.

    Raises WorkFailedError if no flight comes near a track.
    """
    # Matrices of a fit are small: threads would wait for each other longer than they compute.
    with threadpool_limits(1):
        reasons = list_reasons(films, names)
        free, last, notes = _solve(films, [name for name in names if name not in reasons], priors)
        while absurd := _find_absurd(free, last):
            reasons |= absurd
            free, last, notes = _solve(films, [name for name in names if name not in reasons], priors)
        if last is None:
            return _finish(free, free, dict.fromkeys(CONTACT, "no track touches a wall") | reasons)
        return _finish(free, last, reasons, notes)


def _solve(
    films: Sequence[Filmed], wanted: Sequence[str], priors: dict[str, tuple[float, float]] | None
) -> tuple[Solution, Solution | None, list[str]]:
    """Return the fit to free flight, that to flights with contact (``None`` if nothing touches), and notes.

    If there is too little free flight, both are the fit to flights with contact.
    """
    noise = [_measure_noise(film) for film in films]
    plain = [name for name in wanted if name not in CONTACT]
    whole = Problem(films, plain, noise, priors)
    x = place_releases(whole, whole.start)
    free, x = _solve_free_flight(whole, x)
    flown = list(enumerate(whole.paths(x)))
    if free is not None and not any(path.contact < whole.until(x, k) for k, path in flown):
        return free, None, []
    contacts = [path.contact + whole.camera(x, k).delay for k, path in flown]
    lasts = [min(c + AFTER_CONTACT, float(f.track.t[-1])) for c, f in zip(contacts, films, strict=True)]
    shown = [film.cut(last) for film, last in zip(films, lasts, strict=True)]
    shown = [cut if len(cut.track.t) >= MIN_FREE else film for cut, film in zip(shown, films, strict=True)]
    lost = sum(len(film.track.t) - len(short.track.t) for film, short in zip(films, shown, strict=True))
    notes = [f"{lost} points more than {AFTER_CONTACT:g} s after the first contact left out"] if lost else []
    noise = list(free.problem.noise) if free is not None else noise
    anchor = None if free is None else free.anchor()
    # Points of free flight count again in this fit, though not in its covariance: what bounces seem to show of drag and
    # weight must not outweigh them.
    problem = Problem(shown, wanted, noise, priors, anchor)
    starts = _list_contacts(problem, problem.take_over(whole, x))
    found = [solve_problem(problem, start, is_near=True) for start in starts]
    ends = _list_ends(merge_solutions(found))
    touching = merge_solutions([*found, *(solve_problem(problem, end, is_near=True) for end in ends)])
    return free or touching, touching, notes


def _measure_noise(film: Filmed) -> float:
    return max(estimate_noise(film.track), MIN_NOISE * film.track.span)


def _find_misfit(solution: Solution) -> str:
    """Return why no factor is known, if frames were lost or a track lies far off the flight that fits it best; else nothing."""
    problem, (share, least) = solution.problem, FILM_NOISE
    if lost := find_lost_frames(solution):
        return f"{lost[0]} lost frames, the first at t = {lost[1]:.3f} s: give it the times of its frames"
    noises = [max(_measure_noise(film), share * film.track.span, least) for film in problem.films]
    ratios = [noise / least for noise, least in zip(problem.noise, noises, strict=True)]
    worst = int(np.argmax(ratios))
    if ratios[worst] < TOO_FAR:
        away = [
            (abs(value - p.start) / p.prior, p.owner, p.name)
            for p, value in zip(problem.parameters, solution.x, strict=True)
            if p.owner >= 0 and np.isfinite(p.prior)
        ]
        deviations, owner, name = max(away, default=(0.0, 0, ""))
        if deviations < MAX_DEVIATIONS:
            return ""
        track = problem.films[owner].track.name
        return f"{track} fits only with '{name}' of its release or camera {deviations:.0f} standard deviations off"
    return (
        f"{problem.films[worst].track.name} lies {ratios[worst]:.0f} times its noise off every flight of the model, as "
        "when frames are lost or a lens bends the picture"
    )


def _find_absurd(*solutions: Solution | None) -> dict[str, str]:
    """Return the factor of a fit that no model errs by, though the films seem to show it well, and why it is left at 1.

    Something acts on the agent that the model lacks, such as the history force. Without that factor, the others follow what
    the films show of them, and the residuals say how well.
    """
    found = {}
    for solution in filter(None, solutions):
        deviation = np.sqrt(np.diag(solution.covariance))
        for j, name in enumerate(solution.problem.names):
            least, most = PLAUSIBLE.get(name, (Factors.MIN, Factors.MAX))
            value = _limit(factor_of(name, float(solution.x[j])))
            if not least <= value <= most and _find_excess(solution, j, solution.x, deviation) < 1.0:
                found[name] = value
    if not found:
        return {}
    worst = max(found, key=lambda name: abs(np.log(found[name])))
    return {worst: f"the tracks ask for {found[worst]:.2g}, so something acts on it that the model lacks"}


def _solve_free_flight(whole: Problem, x: FloatArray) -> tuple[Solution | None, FloatArray]:
    """Return the fit to what the films show before any contact, and its unknowns; ``None`` if that is too little.

    After a contact a flight depends on the finest details of the release: what it shows of drag and weight is not to be
    trusted. When the contact is, depends on the fit, so there are several.
    """
    found = None
    for share in SHARES:
        films = [
            film.cut(whole.camera(x, k).delay + _end_free_flight(path, share))
            if path.contact < whole.until(x, k)
            else film
            for k, (film, path) in enumerate(zip(whole.films, whole.paths(x), strict=True))
        ]
        if min(len(film.track.t) for film in films) < MIN_FREE:
            return None, x
        if found is not None and [len(f.track.t) for f in films] == [len(f.track.t) for f in found.problem.films]:
            break
        problem = Problem(films, whole.names, found.problem.noise if found else whole.noise, whole.known_before)
        found = solve_problem(problem, x)
        x = found.x
    return found, x


def _end_free_flight(path: Path, share: float) -> float:
    """Return the time (s) up to which a flight is free, even if it was released a little lower than the model has it."""
    k = int(np.searchsorted(path.t, path.contact)) - 1
    speed = float(np.linalg.norm(path.velocity[max(k, 0)]))
    return share * path.contact - 3 * RELEASE_RISE / max(speed, 0.01)


def _list_contacts(problem: Problem, x: FloatArray) -> list[FloatArray]:
    """Return the unknowns with each start of the last coefficient of contact, and those of the others that fit best with it.

    Starts with which the films show the same are one: the last coefficient may have no effect on them.
    """
    places, data = [j for j, name in enumerate(problem.names) if name in CONTACT], sum(problem.counts)
    best: dict[float, tuple[float, float, FloatArray]] = {}
    for values in product(STARTS, repeat=len(places)):
        trial = x.copy()
        trial[places] = np.clip(values, problem.low[places], problem.high[places])
        terms = np.minimum(problem.residuals(trial) ** 2, 100.0)
        cost, last = float(terms.sum()), float(trial[places[-1]]) if places else 0.0
        if last not in best or cost < best[last][0]:
            best[last] = (cost, round(float(terms[:data].sum()), 1), trial)
    by_cost = sorted(best.values(), key=lambda found: -found[0])
    return list({shown: trial for _, shown, trial in by_cost}.values())


def _list_ends(solution: Solution) -> list[FloatArray]:
    """Return the unknowns at both ends of each interval of a coefficient of contact that may count, the others as expected there.

    A bounce depends on the finest details of the release. So there are many hollows, and the slopes in one do not show
    how far away the others are: what the fits from these ends find widens the interval.
    """
    problem, covariance = solution.problem, solution.covariance
    found = []
    for j, name in enumerate(problem.names):
        half = Calibration.quantile * float(np.sqrt(covariance[j, j]))
        if name in CONTACT and half < MAX_WIDTH:
            away = half * covariance[:, j] / covariance[j, j]
            found += [np.clip(solution.x + sign * away, problem.low, problem.high) for sign in (-1.0, 1.0)]
    return found


def list_reasons(films: Sequence[Filmed], names: Sequence[str]) -> dict[str, str]:
    """Return why factors cannot be fitted to these films at all."""
    reasons = {name: "not asked for" for name in Factors.names if name not in names}
    benches = [film.bench for film in films]
    drags = [bench.coefficients.drag for bench in benches]
    damped = any(
        bench.coefficients.linear_damping.any() or bench.coefficients.quadratic_damping.any() for bench in benches
    )
    is_round = all(d is not None and d.round_area > ROUND * 0.25 * np.pi * d.diameter**2 for d in drags)
    if not damped:
        if all(drag is None for drag in drags):
            why = "the agent's model has no drag (hydrodynamics.drag = 'strips')"
            reasons |= {"axial_drag": why, "cross_drag": why}
        elif is_round:
            reasons["axial_drag"] = "a sphere has one drag, which is that of cross_drag"
    half_seen = [film.track.name for film in films if not film.seen_axes.all()]
    if half_seen and not is_round:
        # Another pitch and another push at the release show the same heights with another drag.
        why = f"{half_seen[0]} needs both coordinates: one does not show how the agent turns"
        return reasons | {name: why for name in Factors.names if name in names}
    if benches[0].hull_weight == 0.0:
        reasons["hull_density"] = "the agent has no hull"
    if not any(bench.scenario.pipe.segments for bench in benches):
        reasons |= dict.fromkeys(CONTACT, "the scenario has no walls")
    elif not any(bench.scenario.contact.friction for bench in benches):
        reasons["friction"] = "contact.friction is 0"
    return reasons


def _judge(solution: Solution, names: Sequence[str]) -> tuple[list[int], FloatArray, FloatArray]:
    """Return which of the factors ``names`` are known, all unknowns with the others at 1, and the deviations of factors.

    One after the other, the factor whose interval is too wide by most is left at 1. The others move to what fits best
    with that, and their variance grows by the square of the move: it may be as wrong as it is large.
    """
    problem, x, covariance = solution.problem, solution.x, solution.covariance
    count = len(problem.names)
    judged = [j for j, name in enumerate(problem.names) if name in names]
    known = list(judged)
    while True:
        left = [j for j in judged if j not in known]
        moved = x.copy()
        if left:
            gain = covariance[:, left] @ np.linalg.pinv(covariance[np.ix_(left, left)], hermitian=True)
            moved = x - gain @ x[left]
        deviation = np.sqrt(np.diag(covariance)[:count] + (moved - x)[:count] ** 2)
        excess = [_find_excess(solution, j, moved, deviation) for j in known]
        if not known or max(excess) <= 1.0:
            return known, moved, deviation
        known.pop(int(np.argmax(excess)))


def _find_excess(solution: Solution, j: int, x: FloatArray, deviation: FloatArray) -> float:
    """Return half of the interval of factor ``j`` over the widest that counts as known."""
    low, middle, high = _find_interval(solution, j, x, deviation)
    problem = solution.problem
    return (high - low) / 2 / find_max_width(problem.films[0].bench, problem.names[j], middle)


def find_max_width(bench: Bench, name: str, factor: float) -> float:
    """Return half of the widest interval of a factor that counts as known.

    The density of the hull must be known itself, since other agents are printed with it, and so must the net weight.
    """
    if name != "hull_density":
        return MAX_WIDTH * factor
    net = abs(bench.net_weight / max(bench.hull_weight, 1e-12) + factor - 1)
    return max(MAX_WIDTH_HULL, MAX_WIDTH * min(max(1.0, factor), net))


def _find_interval(solution: Solution, j: int, x: FloatArray, deviation: FloatArray) -> tuple[float, float, float]:
    """Return low, value and high of factor ``j`` from the unknowns and the deviations of factors."""
    from scipy.special import stdtrit

    problem, value = solution.problem, float(x[j])
    freedom = max(3.0, sum(problem.counts) - len(problem.parameters))
    width = float(stdtrit(freedom, 0.5 + CONFIDENCE / 2)) * float(deviation[j])
    low, middle, high = (_limit(factor_of(problem.names[j], v)) for v in (value - width, value, value + width))
    return low, middle, high


def _estimate(solution: Solution, names: Sequence[str], reasons: Mapping[str, str]) -> dict[str, FactorEstimate]:
    """Return what is known of the factors ``names``; ``reasons`` are why some cannot be."""
    problem = solution.problem
    if misfit := _find_misfit(solution):
        return {name: FactorEstimate(reason=reasons.get(name, misfit)) for name in names}
    known, judged, deviation = _judge(solution, names)
    own = np.sqrt(np.diag(solution.covariance))
    correlation = solution.covariance / np.outer(own, own)
    found = {}
    for name in names:
        if name in reasons:
            found[name] = FactorEstimate(reason=reasons[name])
            continue
        j = problem.names.index(name)
        if j in known:
            low, middle, high = _find_interval(solution, j, judged, deviation)
            found[name] = FactorEstimate(middle, low, high, True)
            continue
        others = [k for k in range(len(problem.names)) if k != j and abs(correlation[j, k]) > ALIKE]
        low, middle, high = _find_interval(solution, j, solution.x, own)
        if own[j] > 0.9 * problem.parameters[j].prior:
            why = "it has no effect on these tracks"
        elif _find_excess(solution, j, solution.x, own) <= 1.0:
            left = [k for k in range(len(problem.names)) if k != j and k not in known]
            most = max(left, key=lambda k: abs(correlation[j, k] * solution.x[k] / own[k]), default=j)
            why = f"it would be {middle:.2g}, but depends on {shown_name(problem.names[most])}, which is not known"
        elif others:
            why = f"the tracks cannot separate it from {' and '.join(shown_name(problem.names[k]) for k in others)}"
        else:
            what = "a hull of" if name == "hull_density" else "anything from"
            why = f"the tracks leave {what} {low:.2g} to {high:.2g} possible"
        found[name] = FactorEstimate(reason=why)
    return found


def _limit(value: float) -> float:
    return float(np.clip(value, Factors.MIN, Factors.MAX))


def _weigh_net(hull: FactorEstimate, net: float, weight: float) -> FactorEstimate:
    """Return the factor on the net weight that follows from that on the hull's density."""
    if not hull.known or net == 0.0 or hull.low is None or hull.high is None:
        return FactorEstimate(reason=hull.reason or "the agent's net weight is 0 in the model")
    value, low, high = (1 + (h - 1) * weight / net for h in (hull.value, hull.low, hull.high))
    return FactorEstimate(value, min(low, high), max(low, high), True)


def _finish(free: Solution, last: Solution, reasons: dict[str, str], notes: Sequence[str] = ()) -> Fit:
    """Return the fit: drag and weight as free flight has shown them, restitution and friction as contact has."""
    touched = [name for name in last.problem.names if name not in free.problem.names]
    falling = [name for name in Factors.names if name not in touched]
    found = _estimate(free, falling, reasons) | _estimate(last, touched, reasons)
    estimates = {name: found[name] for name in Factors.names}
    problem, bench = last.problem, last.problem.films[0].bench
    nuisance = range(len(problem.names), len(last.x))
    calibrated, plain = last.x.copy(), last.x.copy()
    for j, name in enumerate(problem.names):
        plain[j] = 0.0
        calibrated[j] = parameter_of(name, estimates[name].value)
    calibrated = find_best(problem, calibrated, nuisance)
    plain = find_best(problem, plain, nuisance, tolerance=1e-3)
    return Fit(
        estimates,
        _weigh_net(estimates["hull_density"], bench.net_weight, bench.hull_weight),
        measure_distance(problem.distances(calibrated)),
        measure_distance(problem.distances(plain)),
        (*_correlate(free, estimates), *_correlate(last, {name: estimates[name] for name in touched})),
        problem,
        calibrated,
        plain,
        tuple(notes),
    )


def _correlate(solution: Solution, estimates: Mapping[str, FactorEstimate]) -> list[tuple[str, str, float]]:
    """Return the correlations of the known ones among factors."""
    names, covariance = solution.problem.names, solution.covariance
    known = [j for j, name in enumerate(names) if name in estimates and estimates[name].known]
    deviation = np.sqrt(np.diag(covariance))
    found = np.round(covariance / np.outer(deviation, deviation), 3)
    pairs = [(i, j) for i, j in combinations(known, 2) if abs(found[i, j]) > NEGLIGIBLE]
    return [(names[i], names[j], float(found[i, j])) for i, j in pairs]


def measure_distance(distances: Sequence[FloatArray]) -> float:
    """Return the root mean square of distances, m."""
    every = np.concatenate([off.ravel() for off in distances])
    return float(np.sqrt(np.nanmean(every**2)))
