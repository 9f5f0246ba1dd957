"""Matrices of the cells that the wall of a tee cuts."""

import math

import numpy as np
import pytest

from driftform.water.parts.tee_wall import Junction
from driftform_tees import solve
from driftform_tees.cells import cut_stiffness


@pytest.mark.long
def test_the_matrices_of_cut_cells_have_no_energy_for_water_at_rest() -> None:
    junction = Junction(0.5, math.pi / 2, 0.1)
    level, wall = solve.make_levels(junction)[0], junction.array()
    corners = (np.argwhere(level.leaves) + level.low) * level.width
    cut = abs(solve._water_levels(corners + level.width / 2, wall)) < 0.3 * level.width
    cells = corners[cut][:20]
    matrices, volumes, points = cut_stiffness(cells, level.width, wall, 1, *solve._gauss(4), solve.PENALTY)
    # The functions of a cell add up to one: a constant potential, of which the water is at rest.
    assert np.allclose(matrices.sum(axis=2), 0.0, atol=1e-12 * matrices.max())
    assert np.allclose(matrices, matrices.transpose(0, 2, 1), atol=1e-12 * matrices.max())
    assert np.all((volumes > 0.0) & (volumes < level.width**3))
    assert len(points) > len(cells)
