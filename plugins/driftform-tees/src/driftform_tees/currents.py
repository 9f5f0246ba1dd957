"""The current of a pipe on a regular grid, as CSV: for Gazebo, and for ``flow.kind = "grid"``."""

import math
from pathlib import Path

import numpy as np

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform.util import files
from driftform.water import Scenario, field
from driftform.water.parts import grid_files

COLUMNS = ("timestamp", "x", "y", "z", "u", "v", "w")
"""Columns of the file: s, m and m/s. The timestamp is 0: Gazebo needs the column, and the current is steady."""

CELLS = 20
"""Cells across the narrowest bore, if no spacing is given and the grid does not become too large."""

MIN_CELLS = 4
"""Least number of cells across the narrowest bore: fewer have no node between its middle and its wall."""

MAX_NODES = 4_000_000
"""Most nodes of the box around the pipe: Gazebo needs 200 MB for them, and sampling takes about a minute."""

LAYERS = 2
"""Layers of nodes around the pipe: every point of the water has all corners of its cell, and reading needs four nodes."""


def usual_spacing(scenario: Scenario) -> float:
    """Return the spacing (m) that is taken if none is given: :data:`CELLS` across the narrowest bore, or coarser.

    It is coarser, rounded up to two digits, if the box around the pipe would have more than :data:`MAX_NODES` nodes.
    """
    low, high = _find_box(scenario)
    spacing = 2 * scenario.pipe.layout.narrowest / CELLS
    while np.prod(_count_nodes(low, high, spacing)) > MAX_NODES:
        step = 10.0 ** (math.floor(math.log10(spacing)) - 1)
        spacing = round((math.floor(spacing / step + 1e-9) + 1) * step, 12)
    return spacing


def sample_current(scenario: Scenario, spacing: float | None = None) -> grid_files.VelocityGrid:
    """Return the mean velocity of the water on a regular grid around the pipe of a scenario.

    Nodes in the water have the velocity there, and their neighbours in the wall one that is extrapolated from it,
    so that interpolation is good up to the wall. The others have none, NaN. Gusts and the acceleration of a uniform current are
    left out.

    Args:
        scenario: with a pipe.
        spacing: of the nodes, m; ``None`` for that of :func:`usual_spacing`.

    Raises InputError in open water, if the spacing is too large for the narrowest bore, or too small for a file.
    """
    pipe = scenario.pipe
    if pipe.is_open:
        raise InputError(
            "the scenario has no pipe: its current is the same everywhere, or a grid already; choose a scenario with a pipe"
        )
    spacing = usual_spacing(scenario) if spacing is None else spacing
    widest = 2 * pipe.layout.narrowest / MIN_CELLS
    if not 0 < spacing <= widest * (1 + 1e-9):
        raise InputError(
            f"a spacing of {spacing:g} m is too large for a bore of {2 * pipe.layout.narrowest:g} m: choose at most {widest:g} m"
            if spacing > 0
            else f"a spacing of {spacing:g} m must be positive"
        )
    low, high = _find_box(scenario)
    shape = _count_nodes(low, high, spacing)
    if math.prod(shape) > MAX_NODES:
        raise InputError(
            f"a spacing of {spacing:g} m takes a grid of {' x '.join(map(str, shape))} nodes, more than {MAX_NODES}: "
            f"choose at least {usual_spacing(scenario):g} m"
        )
    origin = 0.5 * (low + high) - 0.5 * spacing * (np.array(shape) - 1)
    grid = grid_files.VelocityGrid(origin, np.full(3, spacing), np.full((*shape, 3), np.nan))
    return _fill_grid(grid, scenario)


def _find_box(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and the highest coordinates of the pipe, m, (3,) each, with a radius beyond its ends."""
    layout = scenario.pipe.layout
    axes = [axis for placed in layout.parts for axis in placed.part.list_axes(0.25 * layout.narrowest)]
    low = np.min([(axis.points - axis.radii[:, None]).min(axis=0) for axis in axes], axis=0)
    high = np.max([(axis.points + axis.radii[:, None]).max(axis=0) for axis in axes], axis=0)
    return low, high


def _count_nodes(low: FloatArray, high: FloatArray, spacing: float) -> tuple[int, int, int]:
    nx, ny, nz = (np.ceil((high - low) / spacing - 1e-9).astype(int) + 1 + 2 * LAYERS).tolist()
    return nx, ny, nz


def _fill_grid(grid: grid_files.VelocityGrid, scenario: Scenario) -> grid_files.VelocityGrid:
    from scipy.ndimage import binary_dilation

    flow = scenario.flow
    steady = flow.model_copy(update={"acceleration": 0.0}) if flow.kind == "uniform" else flow
    known = (field.wall_distance(grid.nodes(), scenario) >= 0).reshape(grid.shape)
    velocity = grid.velocity.copy()
    velocity[known] = field.water_velocity(grid.nodes()[known], 0.0, scenario.model_copy(update={"flow": steady}))
    near = binary_dilation(known, np.ones((3, 3, 3), dtype=bool))
    filled = grid_files.fill_nodes(velocity, known)
    return grid_files.VelocityGrid(grid.origin, grid.spacing, np.where(near[..., None], filled, np.nan))


def write_current(path: Path, grid: grid_files.VelocityGrid) -> int:
    """Write a grid as CSV with :data:`COLUMNS`, without its nodes that have no velocity; return the number of rows."""
    known = np.asarray(np.isfinite(grid.velocity).all(axis=3))

    def write(part: Path) -> None:
        with part.open("w", encoding="utf-8", newline="") as file:
            file.write(",".join(COLUMNS) + "\n")
            for kept, places, speeds in zip(known, grid.nodes(), grid.velocity, strict=True):
                # The same text for the same coordinate: Gazebo compares all digits.
                rows = np.concatenate([places, speeds], axis=2)[kept]
                np.savetxt(file, rows, "0,%.9g,%.9g,%.9g,%.7g,%.7g,%.7g")

    files.write_whole(path, write)
    return int(known.sum())
