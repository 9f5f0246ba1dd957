"""Ideal flow in a tee: the potentials of two flows, by Galerkin's method in hierarchical splines.

The potential phi minimises the integral of |grad phi|^2 / 2 over the water minus that of q phi over the ends, where q is
the normal velocity there. Its natural condition on the wall is that no water crosses it; a penalty on the square of
the normal velocity, which the solution satisfies exactly, reduces the leakage that the discrete solution has (Freund and
Stenberg 1995 use such terms for other conditions). Unknowns are even in y.
"""

import sys
from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform.util import allocating, progress
from driftform.water.parts import tee_flow, tee_store, tee_wall
from driftform_tees.cells import cut_stiffness, gradient_rows, value_rows
from driftform_tees.hierarchy import BoolArray, IntArray, Level, build_levels, coefficient_matrices
from driftform_tees.region import distance_beyond_ends, distance_from_ball

GRADING = 0.5
"""Largest width of a cell over its distance from the fillet, plus the width of the finest."""

PENALTY = 10.0
"""Weight of the penalty, in widths of a cell."""

OUTSIDE = 1e-6
"""Weight of the energy in the part of a cell that lies in the wall: it keeps functions that hardly touch the water bounded."""

TOLERANCE = 1e-8
"""Relative residual at which the conjugate gradients stop."""

ASSEMBLY = 0.5
"""Share of the time that the matrix takes; the conjugate gradients take the rest."""

CELLS = 1000
"""Cells whose entries are in memory at one time, 32 kB each."""

ShowShare: TypeAlias = Callable[[float], None]
"""Takes the share of the work that is done."""


def solve_tee(junction: tee_wall.Junction) -> tee_store.TeePotentials:
    """Compute the two flows in a tee, as driftform stores them, in some minutes; progress is shown in percent, and its errors in a line.

    Raises WorkFailedError if these are too large.
    """
    wall = junction.array()
    levels = make_levels(junction)
    matrices, starts = coefficient_matrices(levels)
    mirror = _mirror_matrix(levels, starts)
    maps = [csr_array(matrix @ mirror) for matrix in matrices]
    ends = _end_points(wall)
    inlet, outlet, end = (_load(points, levels, maps) for points in ends)
    loads = np.stack([outlet - inlet, end - inlet], axis=1)
    with progress.count_progress("% of the flow in the tee") as count:
        shown = 0

        def show(share: float) -> None:
            nonlocal shown
            while shown < min(100, int(100 * share)):
                shown += 1
                count(shown, 100)

        stiffness = _assemble(levels, maps, wall, lambda share: show(ASSEMBLY * share))
        found = solve_system(stiffness, loads, lambda share: show(ASSEMBLY + (1 - ASSEMBLY) * share))
        show(1.0)
    rows, flows, place = [], [], tee_store.HEAD + tee_store.LEVEL_SIZE * len(levels)
    for level, P in zip(levels, maps, strict=True):
        # Functions that touch only cells with y < 0 are left out; others that no cell of the region needs have none.
        first = -int(level.low[1])
        values = np.asarray(P @ found).reshape(*level.active.shape, 2)[:, first:]
        flows.append(np.where(level.touched()[:, first:, :, None], values, np.nan).reshape(-1, 2))
        rows += [level.width, level.low[0], 0, level.low[2], *values.shape[:3], place]
        place += len(flows[-1])
    head = np.array([len(levels), *[0] * (tee_store.HEAD - 1), *rows], dtype=np.float64)
    through, branch = np.concatenate(flows).T.copy()
    solved = tee_store.TeePotentials(head, through - np.nanmean(through), branch - np.nanmean(branch))
    print(describe_errors(junction, solved, ends), file=sys.stderr, flush=True)
    return solved


def describe_errors(junction: tee_wall.Junction, found: tee_store.TeePotentials, ends: Sequence[FloatArray]) -> str:
    """Return the errors of a solved flow in a line: of the flux through its legs, and its divergence beside its wall.

    Raises WorkFailedError if they are so large that no body should fly by it: the cells are too wide for the edge.
    """
    wall, potential = junction.array(), 0.6 * found.through + 0.4 * found.branch
    field = tee_flow.pack_field(1.0, False, junction, found.head, potential)
    axes = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [wall[tee_wall.COSINE], 0.0, wall[tee_wall.SINE]]])
    off = 0.0
    for points, along, size, flux in zip(ends, axes, (-1.0, 1.0, junction.branch), (1.0, 0.6, 0.4), strict=True):
        inside = (points[:, :3] - 2 * size * along).tolist()
        speeds = np.array([tee_flow.tee_motion(tuple(point), field)[0] for point in inside]) @ along
        off = max(off, abs(2 / np.pi * size**2 * float(speeds @ points[:, 3]) - flux))
    low, high = (1 - wall[tee_wall.UPSTREAM], -1, -1), (wall[tee_wall.DOWNSTREAM] - 1, 1, wall[tee_wall.SIDE])
    points = np.random.default_rng(0).uniform(low, high, (100_000, 3))
    # The legs end elsewhere, and the flow there is of no interest.
    points = points[points @ axes[2] < wall[tee_wall.SIDE] - junction.branch]
    levels = _reach_levels(points, wall, 0.0)
    near = points[(levels > -junction.fillet) & (levels < -0.01)][:4000].tolist()
    slopes = np.array([tee_flow.tee_motion(tuple(point), field)[1] for point in near])
    share = float(np.sqrt((np.trace(slopes, axis1=1, axis2=2) ** 2).sum() / (slopes**2).sum()))
    line = (
        f"errors of this flow: {100 * off:.2g} % of the flux, and a divergence of {100 * share:.2g} % of the gradient"
    )
    if not (off < 0.005 and share < 0.25):
        raise WorkFailedError(f"{line}: too large to fly by; choose a larger fillet, or an angle nearer to 90 degrees")
    return f"{line} (of those that come with driftform, at most 0.03 and 7 %)"


def make_levels(junction: tee_wall.Junction) -> list[Level]:
    """Return the grids of a tee."""
    wall, h, r = junction.array(), junction.width, junction.branch
    c, s, end = wall[tee_wall.COSINE], wall[tee_wall.SINE], wall[tee_wall.SIDE]
    # An oblique end may need the next cell.
    more = 0.25 * h if c > 0 else 0.0
    low = np.array([min(-wall[tee_wall.UPSTREAM], end * c - r * s - more), -1.0, -1.0])
    high = np.array([max(wall[tee_wall.DOWNSTREAM], end * c + r * s + more), 1.0, end * s + r * c + more])
    first, last = np.floor(low / h + 1e-9).astype(np.int64), np.ceil(high / h - 1e-9).astype(np.int64)
    nx, ny, nz = (last - first).tolist()
    finest = junction.finest

    def touches(centres: FloatArray, width: float) -> BoolArray:
        level = _reach_levels(centres, wall, 0.0)
        found = level < -1e-9
        close = ~found & (level < 1.2 * width)
        steps = np.linspace(-0.5, 0.5, 5) * width
        grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
        points = (centres[close][:, None] + grid).reshape(-1, 3)
        # Between these points the level changes by less than a quarter of the width.
        near = _reach_levels(points, wall, 0.25 * width) < -1e-9
        found[close] = near.reshape(-1, len(grid)).any(axis=1)
        return np.asarray(found)

    def refine(centres: FloatArray, width: float) -> BoolArray:
        away = np.maximum(_distances_from_ball(centres, wall) - 0.87 * width, 0)
        x, y, z = centres.T
        in_branch = (np.hypot(x * s - z * c, y) < r + width) & (np.hypot(y, z) > 1)
        widest = np.where(in_branch, 0.5 * r, 1.0)
        return np.asarray(width > np.minimum(GRADING * away + finest, widest) * (1 + 1e-9))

    return build_levels(h, first, (nx, ny, nz), touches, refine)


@allocating
def _reach_levels(points: FloatArray, wall: FloatArray, margin: float) -> FloatArray:
    """Return levels of the water with a ``margin`` in the wall and beyond an end that is oblique to the grid."""
    out = np.empty(len(points))
    oblique = margin if wall[tee_wall.COSINE] > 0.0 else 0.0
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        beyond = distance_beyond_ends(x, y, z, wall)
        if x > -wall[tee_wall.UPSTREAM] and x < wall[tee_wall.DOWNSTREAM]:
            beyond -= oblique
        out[i] = max(tee_wall.wall_level(x, y, z, wall)[0] - margin, beyond)
    return out


@allocating
def _distances_from_ball(points: FloatArray, wall: FloatArray) -> FloatArray:
    out = np.empty(len(points))
    for i in range(len(points)):
        out[i] = distance_from_ball(points[i, 0], points[i, 1], points[i, 2], wall)
    return out


def _assemble(levels: Sequence[Level], maps: Sequence[csr_array], wall: FloatArray, show: ShowShare) -> csr_array:
    """Return the matrix of the system."""
    reference, (nodes, weights) = _whole_stiffness(), _gauss(4)
    laid = [_lay_cells(level, wall) for level in levels]
    matrix, done, count = csr_array((maps[0].shape[1],) * 2), 0, sum(int(cut.sum()) for _, _, cut in laid)
    for level, P, (cells, corners, cut) in zip(levels, maps, laid, strict=True):
        own = csr_array((level.active.size,) * 2)
        # Cells at the wall come last: they alone take time.
        for rows in np.array_split(np.argsort(cut, kind="stable"), 1 + len(cells) // CELLS):
            here, entries = cut[rows], np.repeat(level.width * reference[None], len(rows), axis=0)
            if here.any():
                found, volumes = cut_stiffness(corners[rows[here]], level.width, wall, 1, nodes, weights, PENALTY)
                dry = np.clip(1 - volumes / level.width**3, 0, 1)
                entries[here] = found + OUTSIDE * level.width * dry[:, None, None] * reference
                done += len(found)
                show(done / count)
            functions = _functions_of(cells[rows], level).astype(np.int32)
            places = (np.repeat(functions, 64, axis=1).ravel(), np.tile(functions, 64).ravel())
            own = own + coo_array((entries.ravel(), places), shape=own.shape).tocsr()
        matrix = matrix + P.T @ own @ P
    return csr_array(matrix)


def _lay_cells(level: Level, wall: FloatArray) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the cells with y >= 0, their corners, and which of them the wall may cut."""
    cells = np.argwhere(level.leaves)
    cells = cells[cells[:, 1] + level.low[1] >= 0]
    corners = (cells + level.low) * level.width
    return cells, corners, _reach_levels(corners + level.width / 2, wall, 0.0) > -1.1 * level.width


def _gauss(count: int) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights of Gauss's rule on 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (nodes + 1) / 2, weights / 2


def _whole_stiffness() -> FloatArray:
    """Return the matrix of a cell of width 1 that is all water, (64, 64)."""
    nodes, weights = _gauss(4)
    points = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    weight = np.einsum("i,j,k->ijk", weights, weights, weights).ravel()
    rows = gradient_rows(points, np.zeros(3), 1.0)
    return np.asarray(rows.T @ (np.repeat(weight, 3)[:, None] * rows))


def _functions_of(cells: IntArray, level: Level) -> IntArray:
    """Return the flat indices of the functions that touch each cell, (n, 64)."""
    size, step = level.active.shape, np.arange(4)
    offsets = (step[:, None, None] * size[1] + step[:, None]) * size[2] + step
    return np.asarray(np.ravel_multi_index(tuple(cells.T), size)[:, None] + offsets.ravel())


def _mirror_matrix(levels: Sequence[Level], starts: IntArray) -> csr_array:
    """Return the matrix from the unknowns, which are those with y >= 0, to all degrees of freedom."""
    kept, images = [], []
    for start, level in zip(starts, levels, strict=False):
        index = np.argwhere(level.active)
        number = np.full(level.active.shape, -1)
        number[level.active] = start + np.arange(len(index))
        # Function m touches the cells m - 3 to m; its mirror image is the function 2 - m.
        place = index[:, 1] + level.low[1]
        index[:, 1] = 2 - place - level.low[1]
        own, twin = number[level.active], number[tuple(index.T)]
        kept.append(own)
        images.append(np.where(place >= 1, own, twin))
    rows, columns = np.concatenate(kept), np.concatenate(images)
    unknown, columns = np.unique(columns, return_inverse=True)
    return coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(rows), len(unknown))).tocsr()


def _end_points(wall: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points and weights over the halves of inlet, outlet and branch's end with y > 0, (n, 4) each."""
    nodes, weights = np.polynomial.legendre.leggauss(48)
    radius, angle = np.meshgrid((nodes + 1) / 2, np.pi * nodes / 2, indexing="ij")
    y, up = (radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()
    weight = (radius * np.outer(weights, weights) * np.pi / 4).ravel()
    r, c, s = wall[tee_wall.END_RADIUS], wall[tee_wall.COSINE], wall[tee_wall.SINE]
    inlet, outlet = (
        np.stack([np.full_like(y, x), y, up, weight], axis=1)
        for x in (-wall[tee_wall.UPSTREAM], wall[tee_wall.DOWNSTREAM])
    )
    side = np.stack([wall[tee_wall.SIDE] * c + r * up * s, r * y, wall[tee_wall.SIDE] * s - r * up * c, weight], axis=1)
    return inlet, outlet, side


def _load(points: FloatArray, levels: Sequence[Level], maps: Sequence[csr_array]) -> FloatArray:
    """Return the mean of each function over half an end, times pi / 2: half of the flux at unit speed through the run."""
    total: FloatArray = np.zeros(maps[0].shape[1])
    for level, P in zip(levels, maps, strict=True):
        # An end at the boundary of a cell belongs to the cell in the water.
        index = np.floor(points[:, :3] * (1 - 1e-9) / level.width).astype(np.int64) - level.low
        clipped = np.clip(index, 0, np.array(level.leaves.shape) - 1)
        here = (index == clipped).all(axis=1) & level.leaves[tuple(clipped.T)]
        if here.any():
            corners = level.width * (index[here] + level.low).astype(np.float64)
            values = value_rows(points[here, :3], corners, level.width)
            own = np.zeros(level.active.size)
            np.add.at(own, _functions_of(index[here], level), values * points[here, 3:])
            total += P.T @ own
    return np.asarray(total * (np.pi / 2) / total.sum())


def solve_system(matrix: csr_array, loads: FloatArray, show: ShowShare = lambda share: None) -> FloatArray:
    """Return the solutions of a positive semidefinite system for several loads (n, k), by conjugate gradients.

    The preconditioner is the diagonal. The potentials are determined up to a constant.
    """
    scaling = 1 / np.sqrt(matrix.diagonal())
    A = csr_array(diags_array(scaling) @ matrix @ diags_array(scaling))
    r = scaling[:, None] * loads
    x, p = np.zeros_like(r), r.copy()
    square = (r * r).sum(axis=0)
    first, goal = square, TOLERANCE**2 * square
    for _ in range(20_000):
        q = A @ p
        step = square / (p * q).sum(axis=0)
        x += step * p
        r -= step * q
        new = (r * r).sum(axis=0)
        if (new < goal).all():
            return np.asarray(scaling[:, None] * x)
        # The logarithm of the residual falls about evenly.
        show(float((np.log(new / first) / np.log(goal / first)).min()))
        p = r + new / square * p
        square = new
    raise ArithmeticError("the conjugate gradients did not converge")
