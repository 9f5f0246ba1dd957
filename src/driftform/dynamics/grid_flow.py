"""The velocity of the water on a regular grid: cubic splines along all three axes, twice continuously differentiable.

Nodes outside the pipe have no velocity, or that of a wall. They are filled by extrapolation from the water, so that the
splines are smooth up to the wall.
"""

import math
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from driftform.dynamics.vectors import Rotation, Vector
from driftform.scenario import GridFlow, Pipe, Scenario
from driftform.scenario.grid_files import VelocityGrid, read_grid
from driftform.types import FloatArray
from driftform.util.compiled import compiled

ORIGIN, SPACING, SHAPE, VALUES = 0, 3, 6, 9
"""Indices in the array of a grid: first node (m), spacing (m), nodes along each axis, and coefficients, 3 at each node."""

MAX_LEAKAGE = 0.1
"""Largest root mean square of the velocity through the wall, relative to the mean speed at the inlet."""

SPEED_TOLERANCE = 0.1
"""Largest deviation of the mean speed at the inlet from that of the scenario, relative to it."""

LINEAR_LAYERS = 3
"""Layers of nodes beyond the water that are extrapolated linearly; those further out are constant."""


def grid_array(scenario: Scenario) -> FloatArray | None:
    """Return the grid of a scenario's flow as :func:`grid_motion` reads it, read-only; ``None`` for other flows.

    Raises
    ------
    ValueError
        if the grid does not fit the pipe: see :func:`check_grid`. The message names the file and the next step.
    """
    flow = scenario.flow
    if not isinstance(flow, GridFlow):
        return None
    path = Path(flow.file)
    try:
        state = path.stat()
    except OSError as error:
        raise ValueError(f"flow.file = '{flow.file}' cannot be read: {error.strerror}") from None
    return _load(path, (state.st_mtime_ns, state.st_size), scenario.pipe, flow.reference)


@lru_cache(maxsize=4)
def _load(path: Path, _: tuple[int, int], pipe: Pipe, reference: float) -> FloatArray:
    try:
        grid = read_grid(path)
        inside = find_water(grid, pipe)
        values = spline_coefficients(fill_nodes(grid.velocity, inside))
    except ValueError as error:
        raise ValueError(f"flow.file = '{path}' {error}") from None
    except ModuleNotFoundError as error:
        raise ValueError(
            f"flow.file = '{path}' needs the package {error.name}: install driftform[grids]"
        ) from None
    array = np.concatenate([grid.origin, grid.spacing, grid.shape, values.ravel()])
    array.flags.writeable = False
    check_grid(array, path, pipe, reference)
    return array
