"""A body of revolution from real numbers: the radius on each side of the core is a B-spline along the axis."""

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from driftform.interfaces import Grammar, Table, option
from driftform.types import FloatArray, Genome, Module, Morphology


class BSplineOptions(Table):
    """Bounds of the shapes, and how finely they are built."""

    points: int = option(4, "control points of the radius on each side of the core", ge=1, le=40)
    modules: int = option(12, "modules on each side, conical frusta that follow the spline", ge=1, le=200)
    length: float = option(0.12, "greatest length of a side; the least is a tenth of it", "m", ge=1e-3, le=10)
    swing: float = option(
        0.012, "most by which a control point is wider or narrower than the hull over the core", "m", gt=0, le=1
    )


class BSplineGrammar(Grammar[BSplineOptions]):
    """A vector: length and control points of the side fore of the core, then the same of the side aft of it, all in m.

    Control points are radii, less that of the hull over the core, at equal distances; the first is 0. A clamped cubic
    B-spline passes along them (de Boor 1978), and modules follow it. Optimisers of vectors can search it.
    """

    name = "bspline"
    Options = BSplineOptions

    def list_genes(self) -> Sequence[tuple[float, float]]:
        """Return the bounds of each number."""
        o = self.options
        return ((o.length / 10, o.length), *[(-o.swing, o.swing)] * o.points) * 2

    def express(self, genome: Genome) -> Morphology:
        """Return the modules that follow the splines.

        Raises ValueError if the genome is one of another grammar, or a number is not one or not between its bounds.
        """
        numbers, count, sides = self.read_symbols(genome), self.options.modules, []
        for length, *points in (numbers[: len(numbers) // 2], numbers[len(numbers) // 2 :]):
            radii, step = (compute_basis(len(points), count) @ points).tolist(), length / count
            sides.append(tuple(Module(math.hypot(step, b - a), math.atan2(b - a, step)) for a, b in pairwise(radii)))
        return Morphology(sides[0], sides[1])


@lru_cache(maxsize=16)
def compute_basis(points: int, count: int) -> FloatArray:
    """Return the weights of the control points after the first at the ends of modules, (count + 1, points).

    They are clamped B-splines of degree 3 on even knots, of less for fewer points (de Boor 1978, ch. IX).

    >>> compute_basis(3, 2).round(3).tolist()
    [[0.0, 0.0, 0.0], [0.375, 0.375, 0.125], [0.0, 0.0, 1.0]]
    """
    from scipy.interpolate import BSpline

    degree = min(3, points)
    knots = np.concatenate([np.zeros(degree), np.linspace(0, 1, points - degree + 2), np.ones(degree)])
    return np.asarray(BSpline.design_matrix(np.linspace(0, 1, count + 1), knots, degree).toarray()[:, 1:])
