"""Adaptive integration of flights in compiled code, with an estimate of the error of the whole flight.

The errors of the steps (:mod:`driftform.motion.loop`) do not give the error of the whole flight: it is estimated as twice the
distance from a second integration with ten times the tolerance. The tolerance is tightened until this error is small enough,
or, in gusts, until that no longer helps: then the path is chaotic, and any other that the same gusts allow is as likely.

A motion that stays in the vertical plane is integrated there: the same steps, of seven numbers instead of thirteen.
"""

import math
from dataclasses import dataclass

import numpy as np

from driftform.motion.flight import SAMPLE, is_finite, position_of, sample_path
from driftform.motion.loop import grow_tolerance, take_all_steps
from driftform.motion.model import FlightModel, pack
from driftform.motion.plane import fill_plane, stays_in_plane
from driftform.types import FloatArray
from driftform.util.compiled import allocating, compiled
from driftform.util.cubic import cubic_point
from driftform.util.small_vectors import dot, subtract

__all__ = [
    "Accuracy", "IntegrationResult", "greatest_distance", "grow_tolerance", "integrate", "integrate_once",
]  # fmt: skip

TOLERANCE_RATIO = 10.0
"""Ratio of the tolerances of the two integrations that are compared."""

SAFETY_FACTOR = 2.0
"""Estimated error of a flight over its distance from the second integration.

Both integrations sometimes err alike, for example after the same collision, so the estimate is not a bound. Of 2000
random agents in `paper`, 1983 have an exact flight to compare with. It is at least the true error for 99.1 % of them, 21
times that in the median (18 if errors were proportional to the tolerance), and at most 100 times for 91 %. Five are off by
more than the millimetre that is asked for: four by up to 4.1 mm, and one by 24 mm, of which both integrations step over
the same graze of the wall. Of 1000 in `pipe-inspection`, whose water damps, none is off by more than 0.5 mm.
"""

CONVERGENCE = 0.5
"""Largest ratio of the errors at a tolerance and at ten times that, of a flight in gusts that converges.

Of bodies that ride the wall in `pipe-inspection`, flights that converge have ratios of 0.02 to 0.4. Others stay some centimetres
apart down to a tolerance of 1e-9.
"""


@dataclass(frozen=True)
class Accuracy:
    """Accuracy of an integration.

    Attributes:
        position: largest accepted estimate of the error of the position, m.
        tolerance: initial tolerance of a step at the release, relative to 1 + |value| in every coordinate (SI).
        tightest: tolerance below which a flight counts as not converged.
        max_step: longest step and gap between samples, s.
        step_limit: number of steps after which a flight fails.
    """

    position: float = 1e-3
    tolerance: float = 1e-6
    tightest: float = 1e-12
    max_step: float = 0.05
    step_limit: int = 200_000


@dataclass(frozen=True, eq=False)
class IntegrationResult:
    """Raw samples of a flight, (k, 14), its estimated error (m), and the tolerance that it needed."""

    samples: FloatArray
    error: float
    tolerance: float

    def distance_from(self, samples: FloatArray) -> float:
        """Return the greatest distance (m) from other raw samples of the same flight, (k, 14); infinite if one ends early."""
        return float(greatest_distance(self.samples, samples))


def integrate(
    model: FlightModel, start: FloatArray, horizon: float, accuracy: Accuracy, first: FloatArray | None = None
) -> IntegrationResult:
    """Return a flight from ``start`` (13,) to the outlet or to ``horizon`` (s); see :class:`Accuracy`.

    If no tolerance makes the error small enough, the result has the last error: infinite if the two integrations do
    not end alike, unless in gusts, or both fail. ``first`` is what :func:`integrate_once` returned for the same arguments, if that is known already.
    """
    if first is None:
        first = integrate_once(model, start, horizon, accuracy)
    return _integrate(model, start, horizon, accuracy, first)


def integrate_once(model: FlightModel, start: FloatArray, horizon: float, accuracy: Accuracy) -> FloatArray:
    """Return raw samples (k, 14) of the first of the flights that :func:`integrate` compares; its error is unknown.

    It has ten times the initial tolerance, and takes a sixth of the time of :func:`integrate`.
    """
    return _integrate(model, start, horizon, accuracy, np.empty((0, SAMPLE))).samples


def _integrate(
    model: FlightModel, start: FloatArray, horizon: float, accuracy: Accuracy, first: FloatArray
) -> IntegrationResult:
    in_plane = stays_in_plane(start, model)
    if in_plane:
        fill_plane(model)
    samples, error, tolerance = _integrate_to_accuracy(
        pack(model),
        model.fittings,
        None if in_plane else True,
        len(model.gusts) > 0,
        start,
        first,
        horizon,
        accuracy.position,
        accuracy.tolerance,
        accuracy.tightest,
        accuracy.max_step,
        accuracy.step_limit,
    )
    return IntegrationResult(samples, error, tolerance)


@allocating
def _integrate_to_accuracy(
    values: FloatArray,
    fittings: FloatArray | None,
    in_space: bool | None,
    has_gusts: bool,
    start: FloatArray,
    coarse: FloatArray,
    horizon: float,
    accepted: float,
    tolerance: float,
    tightest: float,
    max_step: float,
    step_limit: int,
) -> tuple[FloatArray, float, float]:
    """Return what :func:`integrate` does, or :func:`integrate_once` if ``coarse`` has no samples.

    If ``in_space`` is None, the motion is that in the plane, and that in space is not compiled.
    """
    is_first, least, before = coarse.shape[0] == 0, 0.0, math.inf
    if is_first:
        tolerance *= TOLERANCE_RATIO
    while True:
        fine = take_all_steps(values, fittings, in_space, start, horizon, tolerance, max_step, step_limit)
        if is_first:
            return fine, math.inf, tolerance
        distance = greatest_distance(coarse, fine, not has_gusts)
        # A distance that falls faster than the tolerance does so by chance.
        error = SAFETY_FACTOR * max(distance, least)
        # What fails alike at two tolerances fails at the next, too, which takes far longer.
        hopeless = has_failed(coarse, step_limit) and has_failed(fine, step_limit)
        hopeless = hopeless or (has_gusts and error > CONVERGENCE * before)
        if error <= accepted or tolerance / TOLERANCE_RATIO < tightest or hopeless:
            return fine, error, tolerance
        coarse, tolerance, least, before = fine, tolerance / TOLERANCE_RATIO, distance / TOLERANCE_RATIO, error


@compiled
def has_failed(samples: FloatArray, step_limit: int) -> bool:
    """Return True if a flight of raw samples (k, 14) ran out of steps, or is not finite at its end."""
    return samples.shape[0] > step_limit or not is_finite(samples[samples.shape[0] - 1])


@compiled
def greatest_distance(a: FloatArray, b: FloatArray, whole: bool = True) -> float:
    """Return the greatest distance (m) between two flights, at the samples of ``b``; both are raw samples, (k, 14).

    Infinite if one is not finite, or, of ``whole`` flights, if one ends well before the other. Others are compared up to the
    earlier end: who is carried out of the pipe along its wall may arrive a little later, and is then near the outlet.
    """
    last_a, last_b = a.shape[0] - 1, b.shape[0] - 1
    if not (is_finite(a[last_a]) and is_finite(b[last_b])):
        return math.inf
    if last_a == 0 or last_b == 0:
        # Both were released past the outlet: a single sample has no path to compare.
        return 0.0 if last_a == last_b else math.inf
    end = min(a[last_a, 0], b[last_b, 0])
    # They may end up to a step apart, past the outlet.
    step = max(a[last_a, 0] - a[last_a - 1, 0], b[last_b, 0] - b[last_b - 1, 0])
    if whole and max(a[last_a, 0], b[last_b, 0]) - end > step:
        return math.inf
    greatest = 0.0
    k = 0
    for row in range(b.shape[0]):
        t = b[row, 0]
        if t > end:
            break
        while k < last_a - 1 and a[k + 1, 0] < t:
            k += 1
        u = (t - a[k, 0]) / (a[k + 1, 0] - a[k, 0])
        apart = subtract(cubic_point(sample_path(a[k], a[k + 1]), u), position_of(b[row]))
        greatest = max(greatest, dot(apart, apart))
    return math.sqrt(greatest)
