"""The error of a whole flight, and flights of a given accuracy: fly twice, compare, tighten.

The errors of the steps (:mod:`driftform.motion.solver.loop`) do not give the error of the whole flight: it is estimated as
twice the distance from a second integration with ten times the tolerance. Two integrations that touch a wall or leave the
water may agree by chance: there, in steady water, at least three are compared. The tolerance is tightened until this error
is small enough, or, in gusts, until that no longer helps: then the path is chaotic, and any other that the same gusts allow
is as likely. The same holds for a body that drag slows and that no tolerance makes exact. Any integrator whose error falls
with a tolerance can be checked so.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from driftform.motion.forces.model import FlightModel
from driftform.motion.forces.state import is_finite, position_of
from driftform.motion.path.curve import bound_cubic_error, sample_path
from driftform.motion.path.trajectory import finish_trajectory, has_touched
from driftform.motion.solver.loop import Limits, take_all_steps
from driftform.motion.solver.tableaus import DOPRI5
from driftform.types import FloatArray, Trajectory
from driftform.util.compiled import compiled
from driftform.util.cubic import cubic_point
from driftform.util.small_vectors import dot, subtract
from driftform.water import Scenario

TOLERANCE_RATIO = 10.0
"""Ratio of the tolerances of the two integrations that are compared."""

SAFETY_FACTOR = 2.0
"""Estimated error of a flight over its distance from the second integration.

Both integrations sometimes err alike, for example after the same collision, so the estimate is not a bound. docs/validation.md
has how often it holds.
"""

TOUCH_FACTOR = 3.0
"""The same for a flight in steady water that touches a wall, or that may rise through the surface.

After a collision the errors of two integrations are sometimes nearly equal by chance, and their difference is too small.
"""

TOLERANCE_GAIN = 5.0
"""Ratio of the errors at two tolerances that differ by :data:`TOLERANCE_RATIO`, on which a stated error relies.

Errors of DOPRI5 fall by 10^(4/5) = 6.3 along smooth motion, and by 4.5 in the median of flights that touch a wall.
"""

LEAST_ERROR = 1e-4
"""Least stated error (m) in steady water, if no less is asked for: equal longest steps err alike, by micrometres."""

CONVERGENCE = 0.5
"""Largest ratio of the errors at a tolerance and at ten times that, of a flight in gusts that converges.

Of bodies that ride the wall in `pipe-inspection`, flights that converge have ratios of 0.02 to 0.4. Others stay some centimetres
apart down to a tolerance of 1e-9.
"""

GUST_RATIO = 10.0
"""Ratio of accuracy and tolerance in gusts to those without: the gusts themselves are known by their statistics only."""

GUST_ACCURACY = 0.01
"""Largest accuracy that gusts loosen, m."""

GUST_TIGHTENING = 1e-3
"""Least tolerance in gusts, relative to the initial one. A flight that needs less is chaotic, and would take seconds."""


@dataclass(frozen=True)
class Accuracy:
    """Accuracy of an integration.

    Attributes:
        position: largest accepted estimate of the error of the position, m.
        tolerance: initial tolerance of a step at the release, relative to 1 + |value| in every coordinate (SI).
        tightest: tolerance below which a flight counts as not converged.
        max_step: longest step and gap between samples, s.
        step_limit: number of steps after which a flight fails.
        near_share: longest step near a wall over ``max_step``: see :meth:`tighten_to`.
    """

    position: float = 1e-3
    tolerance: float = 1e-6
    tightest: float = 1e-12
    max_step: float = 0.05
    step_limit: int = 200_000
    near_share: float = 1.0

    def tighten_to(self, tolerance: float) -> "Accuracy":
        """Return this accuracy at another tolerance.

        Longest steps near a wall fall with the tolerance as the steps do that the error control of DOPRI5 chooses. If two
        integrations took the same longest steps, they would err alike, and their difference would not show it.
        """
        ratio = tolerance / (TOLERANCE_RATIO * self.tolerance)
        return replace(self, tolerance=tolerance, near_share=min(1.0, ratio ** (1 / DOPRI5.power)))

    def loosen_for_gusts(self) -> "Accuracy":
        """Return the accuracy that a flight in gusts has where one without them has this."""
        position = max(self.position, min(GUST_RATIO * self.position, GUST_ACCURACY))
        tolerance = GUST_RATIO * self.tolerance
        tightest = max(self.tightest, GUST_TIGHTENING * tolerance)
        return replace(self, position=position, tolerance=tolerance, tightest=tightest)


@dataclass(frozen=True, eq=False)
class IntegrationResult:
    """A flight of a given accuracy.

    Attributes:
        samples: raw samples, (k, 14).
        error: estimated, m.
        tolerance: that it needed.
        other: raw samples of the flight that it was compared with.
    """

    samples: FloatArray
    error: float
    tolerance: float
    other: FloatArray


def fly_checked(
    fly: Callable[[float], FloatArray],
    model: FlightModel,
    scenario: Scenario,
    accuracy: Accuracy,
    matters: Callable[[Trajectory], bool] | None = None,
) -> Trajectory:
    """Return the flight of a model in its scenario, with an estimate of its error; unchecked if it does not matter.

    Args:
        fly: returns the raw samples (k, 14) of the flight at a tolerance.
        model, scenario: of the flight.
        accuracy: of a flight without gusts.
        matters: whether a first flight, with ten times the tolerance, is worth a check; all are if it is omitted.
    """
    if scenario.has_gusts:
        accuracy = accuracy.loosen_for_gusts()
    accepted = math.inf if may_be_chaotic(model) else accuracy.position
    horizon, limit = scenario.flight.horizon, accuracy.step_limit
    first = fly(TOLERANCE_RATIO * accuracy.tolerance)
    if matters is not None:
        screened = finish_trajectory(first, model, horizon, limit)
        if not matters(screened):
            return screened
    flown = tighten(fly, first, model, accuracy)
    return finish_trajectory(flown.samples, model, horizon, limit, flown.error, accepted, flown.other)


def tighten(
    fly: Callable[[float], FloatArray], first: FloatArray, model: FlightModel, accuracy: Accuracy
) -> IntegrationResult:
    """Return the flight at the first tolerance that makes its error small enough; see :func:`fly_checked`.

    If no tolerance does, the result has the last error: infinite if the two integrations do not end alike, unless the path may
    be chaotic, or both fail. ``first`` are the samples at ten times the tolerance of ``accuracy``. Near a wall
    or a surface one comparison does not accept a flight: a third integration, with ten times that, makes two.
    """
    coarse, tolerance, before, has_gusts = first, accuracy.tolerance, math.inf, len(model.gusts) > 0
    distances: list[float] = []
    while True:
        fine = fly(tolerance)
        distances.insert(0, float(greatest_distance(coarse, fine, not has_gusts)))
        # A wall and a free surface are kinks of the forces, after which errors vary by chance.
        meets_kinks = not has_gusts and (len(model.slices) > 0 or bool(has_touched(fine, model)))
        factor = TOUCH_FACTOR if meets_kinks else SAFETY_FACTOR
        # A distance that falls faster than the tolerance does so by chance.
        error = factor * bound_distance(distances[:2], TOLERANCE_RATIO)
        can_tighten = tolerance / TOLERANCE_RATIO >= accuracy.tightest
        if meets_kinks and can_tighten and len(distances) == 1 and error <= accuracy.position:
            distances.append(float(greatest_distance(fly(TOLERANCE_RATIO**2 * tolerance), coarse)))
            error = factor * bound_distance(distances, TOLERANCE_RATIO)
        # What fails alike at two tolerances fails at the next, too, which takes far longer.
        hopeless = has_failed(coarse, accuracy.step_limit) and has_failed(fine, accuracy.step_limit)
        hopeless = hopeless or (has_gusts and error > CONVERGENCE * before)
        if error <= accuracy.position or not can_tighten or hopeless:
            if not has_gusts and error <= accuracy.position and len(fine) > 1:
                # Most accepted flights are as exact as that; what is stated covers the others.
                bound = factor * bound_distance(distances, TOLERANCE_GAIN) + float(bound_cubic_error(fine))
                error = min(max(bound, LEAST_ERROR), accuracy.position)
            if math.isinf(error) and may_be_chaotic(model):
                error = TOUCH_FACTOR * float(greatest_distance(coarse, fine, False))
            return IntegrationResult(fine, error, tolerance, coarse)
        coarse, tolerance, before = fine, tolerance / TOLERANCE_RATIO, error


def bound_distance(distances: list[float], gain: float) -> float:
    """Return the greatest of the distances (m) between integrations, each ``gain`` times as large as at the next tolerance."""
    return max(distance / gain**k for k, distance in enumerate(distances))


def may_be_chaotic(model: FlightModel) -> bool:
    """Return True if a path that no tolerance fixes is one of many that are as likely: in gusts, and where drag acts.

    A body that hops along the wall with almost no weight takes another path after any change, and drag keeps all of them near each
    other. Without drag nothing does.
    """
    return len(model.gusts) > 0 or len(model.strips) > 0


def integrate(model: FlightModel, start: FloatArray, horizon: float, accuracy: Accuracy) -> IntegrationResult:
    """Return a flight by our own integrator from ``start`` (13,), or (17,) in gusts, to the outlet or to ``horizon`` (s)."""

    def fly(tolerance: float) -> FloatArray:
        return integrate_once(model, start, horizon, accuracy.tighten_to(tolerance))

    return tighten(fly, fly(TOLERANCE_RATIO * accuracy.tolerance), model, accuracy)


def integrate_once(model: FlightModel, start: FloatArray, horizon: float, accuracy: Accuracy) -> FloatArray:
    """Return raw samples (k, 14) of one flight at the tolerance of ``accuracy``; its error is unknown."""
    # In gusts the path is known by its statistics only.
    near_step = accuracy.max_step * (accuracy.near_share if len(model.gusts) == 0 else 1.0)
    limits = Limits(horizon, accuracy.tolerance, accuracy.max_step, near_step, accuracy.step_limit)
    return take_all_steps(model, start, limits)


def has_failed(samples: FloatArray, step_limit: int) -> bool:
    """Return True if a flight of raw samples (k, 14) ran out of steps, or is not finite at its end."""
    return len(samples) > step_limit or not bool(np.isfinite(samples[-1]).all())


@compiled
def greatest_distance(a: FloatArray, b: FloatArray, whole: bool = True) -> float:
    """Return the greatest distance (m) between two flights, at the samples of ``b``; both are raw samples, (k, 14).

    Infinite if one is not finite, or, of ``whole`` flights, if one ends well before the other. Others are compared up to the
    earlier end: a body that is carried out of the pipe along its wall may arrive a little later, and is then near the outlet.
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
