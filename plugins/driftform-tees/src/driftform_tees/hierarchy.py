"""Hierarchical cubic B-splines on nested grids (truncated: Giannelli, Juettler and Speleers 2012).

The grid of a level has cubic cells, half as wide as those of the level before; cell (i, j, k) is touched by the functions
(i..i+3, j..j+3, k..k+3). The region of a level is a set of its cells, contained in that of the level before. A function
is a degree of freedom if its support in the water lies in the region of its level, and not in that of the next one.
On the region of a level, the coefficients of the spline are the degrees of freedom where that level has any, and the
subdivided coefficients of the level before elsewhere. So the spline on a cell is that of a single grid, and it is twice
continuously differentiable throughout.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation
from scipy.sparse import coo_array, csr_array

from driftform.types import FloatArray

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Level:
    """One grid.

    Attributes:
        width: of a cell.
        low: corner of the box of cells, in cells from the origin, (3,).
        region: cells of the box that belong to the region and touch the water, (nx, ny, nz).
        leaves: cells of the region that are not refined.
        active: functions of the box that are degrees of freedom, (nx + 3, ny + 3, nz + 3).
    """

    width: float
    low: IntArray
    region: BoolArray
    leaves: BoolArray
    active: BoolArray

    def touched(self) -> BoolArray:
        """Return the functions that touch a cell of the region, (nx + 3, ny + 3, nz + 3)."""
        return _touching(self.region)


def _touching(cells: BoolArray) -> BoolArray:
    """Return the functions that touch any of the cells: function m touches the cells m - 3 to m."""
    return np.asarray(binary_dilation(np.pad(cells, ((0, 3),) * 3), np.ones((4, 4, 4)), origin=-2))


def build_levels(
    width: float,
    low: IntArray,
    shape: tuple[int, int, int],
    touches: Callable[[FloatArray, float], BoolArray],
    refine: Callable[[FloatArray, float], BoolArray],
    most: int = 8,
) -> list[Level]:
    """Return the levels of a box of cells, the coarsest first.

    Args:
        width, low, shape: of the coarsest grid: see :class:`Level`.
        touches, refine: return whether cells with these centres (n, 3) and this width touch the water, and whether
            they are too wide.
    """
    levels: list[Level] = []
    region = np.ones(shape, dtype=bool)
    for _ in range(most):
        wet = touches(_centres(np.ones(np.add(region.shape, 6), dtype=bool), low - 3, width), width)
        wet = wet.reshape(np.add(region.shape, 6))
        region &= wet[3:-3, 3:-3, 3:-3]
        chosen = np.zeros_like(region)
        chosen[region] = refine(_centres(region, low, width), width)
        chosen = binary_dilation(chosen, np.ones((3, 3, 3)), mask=region) if chosen.any() else chosen
        leaves = region & ~chosen
        elsewhere = wet & ~np.pad(region, 3)
        active = _touching(leaves) & ~_touching(elsewhere)[3:-3, 3:-3, 3:-3]
        levels.append(Level(width, low, region, leaves, active))
        if not chosen.any():
            return levels
        index = np.argwhere(chosen)
        first, last = index.min(axis=0), index.max(axis=0) + 1
        part = chosen[tuple(slice(a, b) for a, b in zip(first, last, strict=True))]
        width, low = width / 2, 2 * (low + first)
        region = part.repeat(2, 0).repeat(2, 1).repeat(2, 2)
    raise ValueError(f"the grid needs more than {most} levels")


def _centres(cells: BoolArray, low: IntArray, width: float) -> FloatArray:
    return np.asarray((np.argwhere(cells) + low + 0.5) * width, dtype=np.float64)


def coefficient_matrices(levels: list[Level]) -> tuple[list[csr_array], IntArray]:
    """Return, for each level, the matrix from the degrees of freedom to the coefficients of its box, flat.

    Coefficients that no cell of the region needs are zero.
    """
    counts = [int(level.active.sum()) for level in levels]
    starts = np.concatenate([[0], np.cumsum(counts)])
    total = int(starts[-1])
    matrices: list[csr_array] = []
    for number, level in enumerate(levels):
        size = level.active.size
        own = np.flatnonzero(level.active)
        columns = starts[number] + np.arange(len(own))
        matrix = coo_array((np.ones(len(own)), (own, columns)), shape=(size, total)).tocsr()
        if number > 0:
            needed = np.flatnonzero(level.touched() & ~level.active)
            matrix = matrix + _subdivision(levels[number - 1], level, needed) @ matrices[-1]
        matrices.append(csr_array(matrix))
    return matrices, starts


def _subdivision(coarse: Level, fine: Level, needed: IntArray) -> csr_array:
    """Return the matrix from the coefficients of a level's box to those of the next one with the indices ``needed``.

    A cubic B-spline is the sum of five of half its width, with the weights 1, 4, 6, 4, 1 over 8.
    """
    place = np.stack(np.unravel_index(needed, fine.active.shape), axis=1) + fine.low
    column, weight = np.zeros((len(needed), 1), dtype=np.int64), np.ones((len(needed), 1))
    for axis in range(3):
        # The function j of the coarse grid contains 2 j - 3 + k of the fine one, k = 0 to 4.
        first = (place[:, axis] + 3) // 2
        j = first[:, None] - np.arange(3) - coarse.low[axis]
        even = (place[:, axis] + 3) % 2 == 0
        share = np.where(even[:, None], [1.0, 6.0, 1.0], [4.0, 4.0, 0.0]) / 8
        j = np.where(share > 0, j, 0)
        column = (column[:, :, None] * coarse.active.shape[axis] + j[:, None, :]).reshape(len(needed), -1)
        weight = (weight[:, :, None] * share[:, None, :]).reshape(len(needed), -1)
    row = np.repeat(needed, weight.shape[1])
    entries = weight.ravel() > 0
    return coo_array(
        (weight.ravel()[entries], (row[entries], column.ravel()[entries])), shape=(fine.active.size, coarse.active.size)
    ).tocsr()
