"""The velocity of the water on a regular grid: cubic splines along all three axes, twice continuously differentiable.

Nodes in the wall, and nodes that the file leaves out next to it, are filled by extrapolation from the water, so that the splines
are smooth up to the wall.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from driftform.errors import InputError
from driftform.types import BoolArray, FloatArray
from driftform.util.compiled import allocating, compiled
from driftform.util.small_vectors import ZERO, Rotation, Vector, add, scale
from driftform.water.parts.grid_files import VelocityGrid, fill_nodes, read_grid
from driftform.water.parts.layout import Layout
from driftform.water.parts.profiles import AT_A_POINT, Spread
from driftform.water.parts.shapes import Axis
from driftform.water.parts.tee_spline import cubic_bends, cubic_slopes, cubic_values
from driftform.water.parts.walls import HEAD, PART, wall_gaps

ORIGIN, SPACING, SHAPE, VALUES = 0, 3, 6, 9
"""Indices in a grid: first node (m), spacing (m), nodes along each axis, and coefficients, 3 at each node.

The grid follows the rows of the pipe's parts in the array ``fittings``.
"""

MAX_LEAKAGE = 0.1
"""Largest root mean square of the velocity through the wall, relative to the mean speed at the inlet."""

SPEED_TOLERANCE = 0.1
"""Largest deviation of the mean speed at the inlet from that of the scenario, relative to it."""

MAX_SPEED = 20.0
"""Largest speed of water in the file, m/s, at a mean speed up to 5 m/s; the fastest tidal currents have half of it."""

EXTENT = 0.05, 1e6
"""Least and greatest extent of a grid along each axis, m."""

MIN_CELLS = 4
"""Smallest number of cells of a grid across the narrowest bore."""


class _WrongGridError(InputError, ValueError):
    """The file of a grid cannot be read or does not fit: input, also where a simulator meets it first."""


def load_grid(file: str, reference: float, layout: Layout, walls: FloatArray) -> FloatArray:
    """Return the array ``fittings`` of a pipe and a grid: the walls, as in :mod:`driftform.water.parts.walls`, and the grid.

    Args:
        file: of the grid.
        reference: mean speed at the inlet in the file, m/s.
        layout: of the pipe, empty in open water.
        walls: array of the pipe without its flow.

    Raises ValueError if the file cannot be read, or does not fit the pipe: see :func:`make_grid` and
    :func:`check_grid`. The message names file and next step.
    """
    path = Path(file)
    try:
        state = path.stat()
    except OSError as error:
        raise _WrongGridError(f"flow.file = '{path}' cannot be read: {error.strerror}") from None
    return _load(path, (state.st_mtime_ns, state.st_size), layout, reference, walls.tobytes())


@lru_cache(maxsize=4)
def _load(path: Path, _: tuple[int, int], layout: Layout, reference: float, walls: bytes) -> FloatArray:
    try:
        grid = read_grid(path)
        _check_units(grid, reference)
        array = make_grid(grid, layout, np.frombuffer(walls))
        if layout.parts:
            check_grid(grid, array, layout, reference)
    except ValueError as error:
        raise _WrongGridError(f"flow.file = '{path}' {error}") from None
    except ModuleNotFoundError as error:
        extra = "netcdf" if path.suffix.lower() == ".nc" else "vtk"
        raise _WrongGridError(
            f"flow.file = '{path}' needs the package {error.name}: pip install 'driftform[{extra}]'"
        ) from None
    return array


def make_grid(grid: VelocityGrid, layout: Layout, walls: FloatArray) -> FloatArray:
    """Return the walls of a pipe and a grid of velocities as one array, as :func:`grid_motion` reads it, (n,), read-only.

    Raises ValueError if a node in the water has no velocity, or if the pipe reaches beyond the grid.
    """
    from scipy.ndimage import spline_filter1d

    known = np.asarray(np.isfinite(grid.velocity).all(axis=3))
    if layout.parts:
        known[known] = wall_gaps(grid.nodes()[known], walls)[0] >= -1e-6 * grid.spacing.max()
    _check_nodes(grid, known, layout, walls)
    values = fill_nodes(grid.velocity, known)
    for axis in range(3):
        values = spline_filter1d(values, order=3, axis=axis, mode="mirror")
    # One more coefficient on each side, so that every cell has four.
    values = np.pad(values, [(1, 1)] * 3 + [(0, 0)], mode="reflect")
    array = np.concatenate([walls, grid.origin, grid.spacing, grid.shape, values.ravel()])
    array.flags.writeable = False
    return array


def _check_units(grid: VelocityGrid, reference: float) -> None:
    """Refuse a grid whose numbers can hardly be metres and metres per second."""
    speed = float(np.linalg.norm(np.nan_to_num(grid.velocity), axis=3).max())
    if not speed <= MAX_SPEED * max(1.0, reference / 5.0):
        raise ValueError(
            f"has a speed of {speed:.4g} m/s: are its velocities in m/s, and nodes without water left out?"
        )
    for axis, extent in zip("xyz", (grid.end - grid.origin).tolist(), strict=True):
        if not EXTENT[0] <= extent <= EXTENT[1]:
            raise ValueError(f"has an extent of {extent:.4g} m along {axis}: are its coordinates in metres?")


def _check_nodes(grid: VelocityGrid, known: BoolArray, layout: Layout, walls: FloatArray) -> None:
    if not layout.parts:
        if not known.all():
            place = grid.origin + grid.spacing * np.argwhere(~known)[0]
            raise ValueError(f"has no velocity at {format_point(place)}: in open water every node needs one")
        return
    step = 0.1 * layout.narrowest
    bores = [axis for placed in layout.parts for axis in placed.part.list_axes(step)]
    points = np.concatenate([axis.points for axis in bores])
    narrowest = 2 * layout.narrowest
    if grid.spacing.max() > narrowest / MIN_CELLS:
        raise ValueError(
            f"has nodes {grid.spacing.max():.3g} m apart, too far for a bore of {narrowest:.3g} m, which needs at least "
            f"{MIN_CELLS} cells across: are its coordinates in metres?"
        )
    low, high = format_point(grid.origin), format_point(grid.end)
    outside = ((points < grid.origin) | (points > grid.end)).any(axis=1)
    if outside.any():
        raise ValueError(
            f"reaches from {low} to {high} m, and the pipe beyond, for example to {format_point(points[outside][0])} m: "
            "do their origins and units agree?"
        )
    beyond = _find_bore_beyond(grid, bores)
    if beyond is not None:
        raise ValueError(
            f"covers only a part of the section: it reaches from {low} to {high} m, and the bore to {format_point(beyond)} m; "
            "a grid must cover the whole bore, a mirrored half included"
        )
    missing = grid.nodes()[~known]
    gaps, _, inside = wall_gaps(missing, walls)
    dry = inside & (gaps > np.linalg.norm(grid.spacing))
    if dry.any():
        raise ValueError(
            f"has no velocity at {int(dry.sum())} nodes in the pipe, for example {format_point(missing[dry][0])} m: do their "
            "origins and units agree?"
        )


def _find_bore_beyond(grid: VelocityGrid, bores: Sequence[Axis]) -> FloatArray | None:
    """Return the point of the bore's wall that lies farthest beyond a grid, m, (3,); ``None`` within a spacing of it."""
    walls = []
    for axis in bores:
        along = np.gradient(axis.points, axis=0)
        along /= np.linalg.norm(along, axis=1)[:, None]
        # The extent of a circle along each axis of the world.
        for a in range(3):
            across = np.eye(3)[a] - along[:, [a]] * along
            length = np.linalg.norm(across, axis=1)[:, None]
            across = axis.radii[:, None] * across / np.where(length > 1e-9, length, np.inf)
            walls += [axis.points + across, axis.points - across]
    points = np.concatenate(walls)
    excess = (np.maximum(grid.origin - points, points - grid.end) / grid.spacing).max(axis=1)
    worst = int(np.argmax(excess))
    return points[worst] if excess[worst] > 1.0 else None


def format_point(point: FloatArray) -> str:
    """Return a point as text, such as (1, 0, -0.5)."""
    return f"({', '.join(f'{x:.4g}' for x in point)})"


def check_grid(grid: VelocityGrid, array: FloatArray, layout: Layout, reference: float) -> None:
    """Check that the water of a grid stays in the pipe, and that its mean speed at the inlet is ``reference`` (m/s).

    Raises ValueError if it does not.
    """
    speed = inlet_speed(array, layout)
    if not abs(speed - reference) <= SPEED_TOLERANCE * reference:
        raise ValueError(
            f"has a mean speed of {speed:.4g} m/s at the inlet, but flow.reference = {reference:g} m/s: set flow.reference, "
            "and flow.speed to the speed of the flight"
        )
    leakage, worst, place = wall_leakage(grid, array)
    if leakage > MAX_LEAKAGE * reference:
        raise ValueError(
            f"leaks: the velocity through the wall is {100 * leakage / reference:.3g} % of the mean speed (root mean square), "
            f"{worst:.3g} m/s at {format_point(place)} m. Do the pipe and the grid have the same shape, origin and units?"
        )


def inlet_speed(array: FloatArray, layout: Layout) -> float:
    """Return the mean speed into the inlet, m/s."""
    inlet = layout.inlet
    nodes, weights = np.polynomial.legendre.leggauss(12)
    angles = 2 * np.pi * np.arange(24) / 24
    total = 0.0
    for node, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
        for angle in angles:
            across = inlet.radius * node * (np.cos(angle) * inlet.axes[1] + np.sin(angle) * inlet.axes[2])
            x, y, z = (inlet.centre + across).tolist()
            total += 2 * node * weight / 24 * float(inlet.axes[0] @ grid_motion((x, y, z), array)[0])
    return total


def wall_leakage(grid: VelocityGrid, array: FloatArray) -> tuple[float, float, FloatArray]:
    """Return the root mean square of the velocity through the wall, the largest (m/s), and where (m, (3,)).

    The points are those of the wall nearest to the nodes within one spacing of it.
    """
    nodes = grid.nodes().reshape(-1, 3)
    gaps, normals, inside = wall_gaps(nodes, array)
    near = inside & (np.abs(gaps) < grid.spacing.max())
    feet = nodes[near] + gaps[near, None] * normals[near]
    through = np.einsum("ij,ij->i", grid_velocities(feet, array), normals[near])
    worst = int(np.argmax(np.abs(through)))
    return float(np.sqrt(np.mean(through**2))), float(abs(through[worst])), feet[worst]


@allocating
def grid_velocities(points: FloatArray, array: FloatArray) -> FloatArray:
    """Return the velocities at points (n, 3), m/s, (n, 3)."""
    found = np.empty((len(points), 3))
    for i in range(len(points)):
        velocity, _ = grid_motion((points[i, 0], points[i, 1], points[i, 2]), array)
        for a in range(3):
            found[i, a] = velocity[a]
    return found


@compiled
def grid_motion(point: Vector, array: FloatArray, spread: Spread = AT_A_POINT) -> tuple[Vector, Rotation]:
    """Return the velocity on a grid (m/s) and its gradient du_i/dx_j (rows i, 1/s) at a point (m).

    The velocity is the mean over a body with this ``spread``, to the second derivatives. Beyond the grid it is that of the
    nearest point of the grid.
    """
    start = HEAD + PART * int(array[0])
    i, u, a = _locate(point[0], array, start)
    j, v, b = _locate(point[1], array, start + 1)
    k, w, c = _locate(point[2], array, start + 2)
    ny, nz = int(array[start + SHAPE + 1]) + 2, int(array[start + SHAPE + 2]) + 2
    X, X1, X2 = cubic_values(u), cubic_slopes(u), cubic_bends(u)
    Y, Y1, Y2 = cubic_values(v), cubic_slopes(v), cubic_bends(v)
    Z, Z1, Z2 = cubic_values(w), cubic_slopes(w), cubic_bends(w)
    # Half of the covariance of the body's volume, in spacings.
    axis, across, more = spread[0], 0.5 * spread[1], 0.5 * (spread[2] - spread[1])
    S_xx, S_xy = a * a * (across + more * axis[0] * axis[0]), 2.0 * a * b * more * axis[0] * axis[1]
    S_yy, S_yz = b * b * (across + more * axis[1] * axis[1]), 2.0 * b * c * more * axis[1] * axis[2]
    S_zz, S_xz = c * c * (across + more * axis[2] * axis[2]), 2.0 * a * c * more * axis[0] * axis[2]
    p, p_x, p_y, p_z = ZERO, ZERO, ZERO, ZERO
    for m in range(4):
        for n in range(4):
            at = start + VALUES + 3 * (((i + m) * ny + j + n) * nz + k)
            s, d, e = ZERO, ZERO, ZERO
            for q in range(4):
                value = (array[at], array[at + 1], array[at + 2])
                s, d, e = add(s, scale(Z[q], value)), add(d, scale(Z1[q], value)), add(e, scale(Z2[q], value))
                at += 3
            g = X[m] * Y[n]
            g_s = g + S_xx * X2[m] * Y[n] + S_yy * X[m] * Y2[n] + S_xy * X1[m] * Y1[n]
            g_d = S_xz * X1[m] * Y[n] + S_yz * X[m] * Y1[n]
            p = add(p, add(scale(g_s, s), add(scale(g_d, d), scale(S_zz * g, e))))
            p_x, p_y, p_z = (add(p_x, scale(X1[m] * Y[n], s)), add(p_y, scale(X[m] * Y1[n], s)), add(p_z, scale(g, d)))
    return p, (
        (a * p_x[0], b * p_y[0], c * p_z[0]),
        (a * p_x[1], b * p_y[1], c * p_z[1]),
        (a * p_x[2], b * p_y[2], c * p_z[2]),
    )


@compiled
def distance_beyond(point: Vector, array: FloatArray) -> float:
    """Return the distance of a point beyond the nearest face of a grid, m; negative in it."""
    start, farthest = HEAD + PART * int(array[0]), -math.inf
    for a in range(3):
        low, spacing = array[start + ORIGIN + a], array[start + SPACING + a]
        high = low + spacing * (array[start + SHAPE + a] - 1.0)
        farthest = max(farthest, low - point[a], point[a] - high)
    return farthest


@compiled
def _locate(x: float, array: FloatArray, place: int) -> tuple[int, float, float]:
    """Return the cell along an axis, the place in it (0 to 1), and one over the spacing, 0 beyond the grid."""
    spacing, count = array[place + SPACING], int(array[place + SHAPE])
    at = (x - array[place + ORIGIN]) / spacing
    inverse = 1.0 / spacing if 0.0 <= at <= count - 1.0 else 0.0
    at = min(max(at, 0.0), count - 1.0)
    cell = min(int(at), count - 2)
    return cell, at - cell, inverse
