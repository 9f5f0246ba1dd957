"""The parts of the solver of ideal flow against closed forms: splines, energies, cut cells, grids, and the linear system."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from driftform.util import progress
from driftform.water.parts.tee_wall import UPSTREAM, Junction
from driftform_tees import solve
from driftform_tees.cells import cut_cell, cut_stiffness, gradient_rows, spline_values, value_rows
from driftform_tees.hierarchy import build_levels, coefficient_matrices

CENTRES = np.arange(-1.0, 3.0)
"""Centres of the four splines of a cell of width 1 at 0."""

LINEAR = np.array([1.0, -2.0, 0.5])


def linear_coefficients(slope):
    """Coefficients of slope . x in a cell: its values at the centres of the splines, as for all linear functions, (64,)."""
    x, y, z = np.meshgrid(CENTRES, CENTRES, CENTRES, indexing="ij")
    return np.asarray(slope[0] * x + slope[1] * y + slope[2] * z).ravel()


@pytest.mark.parametrize("u", [0.0, 0.2, 0.5, 0.9, 1.0])
def test_the_splines_of_a_cell_are_those_of_scipy(u):
    values, slopes = np.empty(4), np.empty(4)
    spline_values(u, values, slopes)
    for k in range(4):
        spline = BSpline.basis_element(np.arange(k - 3.0, k + 2.0), extrapolate=False)
        at = min(max(u, k - 3 + 1e-12), k + 1 - 1e-12)
        assert values[k] == pytest.approx(float(spline(at)), abs=1e-11)
        assert slopes[k] == pytest.approx(float(spline.derivative()(at)), abs=1e-10)


def test_a_linear_potential_has_its_values_and_its_gradient_everywhere():
    points = np.random.default_rng(0).uniform(0, 1, (20, 3))
    corner, width, c = np.array([2.0, -1.0, 4.0]), 0.25, linear_coefficients(LINEAR)
    placed = corner + width * points
    assert value_rows(placed, np.tile(corner, (20, 1)), width) @ c == pytest.approx(points @ LINEAR)
    gradients = (gradient_rows(placed, corner, width) @ c).reshape(20, 3)
    assert gradients == pytest.approx(np.tile(LINEAR / width, (20, 1)))


def test_the_energy_of_a_cell_of_water_is_the_integral_of_the_squared_velocity():
    K, c = solve._whole_stiffness(), linear_coefficients(LINEAR)
    assert c @ K @ c == pytest.approx(LINEAR @ LINEAR)
    # x^2 has the coefficients (i - 1/3) for splines at the centres, and the integral of (2 x)^2 over 0 to 1 is 4/3.
    square = np.repeat(CENTRES**2 - 1 / 3, 16)
    assert square @ K @ square == pytest.approx(4 / 3)


@pytest.mark.long
def test_the_cells_across_a_straight_bore_add_up_to_its_volume_and_its_wall():
    junction = Junction(0.5, math.pi / 2, 0.1)
    wall, width, parts = junction.array(), 0.25, 4
    nodes, weights = solve._gauss(4)
    side = np.arange(-1.0, 1.0, width)
    inner, outer = [], []
    for y in side:
        for z in side:
            corner = np.array([-wall[UPSTREAM] + width, y, z])
            inside, edge = cut_cell(corner, width, wall, parts, nodes, weights)
            inner.append(inside)
            outer.append(edge)
    water, rim = np.concatenate(inner), np.concatenate(outer)
    assert water[:, 3].sum() == pytest.approx(math.pi * width, rel=1e-3)
    # The second moment of a disc of radius 1 about its diameter is pi / 4.
    for axis in (1, 2):
        assert water[:, 3] @ water[:, axis] ** 2 == pytest.approx(math.pi / 4 * width, rel=2e-3)
    assert rim[:, 6].sum() == pytest.approx(2 * math.pi * width, rel=1e-2)
    assert rim[:, 3:6] == pytest.approx(rim[:, :3] * [0.0, 1.0, 1.0], abs=1e-9)


def test_points_of_an_end_integrate_over_half_a_disc():
    for angle in (90, 50):
        junction = Junction(0.5, math.radians(angle), 0.1)
        for points, radius in zip(solve._end_points(junction.array()), (1.0, 1.0, 0.5), strict=True):
            weight = points[:, 3]
            assert weight.sum() == pytest.approx(math.pi / 2, rel=1e-9)
            # The mean of y over half a disc of radius r is 4 r / (3 pi), that of the squared distance from its centre r^2 / 2.
            assert weight @ points[:, 1] / weight.sum() == pytest.approx(4 * radius / (3 * math.pi), rel=1e-6)
            centre = weight @ points[:, :3] / weight.sum() * [1.0, 0.0, 1.0]
            away = ((points[:, :3] - centre) ** 2).sum(axis=1)
            assert weight @ away / weight.sum() == pytest.approx(radius**2 / 2, rel=1e-6)


def test_finer_grids_continue_a_linear_potential():
    """A box whose middle is refined twice: with linear degrees of freedom, all levels have the linear coefficients."""

    def touches(centres, width):
        return np.asarray(((centres > 0.0) & (centres < 8.0)).all(axis=1))

    def refine(centres, width):
        return np.asarray((np.abs(centres - 4.0) < 1.0).all(axis=1) & (width > 0.3))

    levels = build_levels(1.0, np.zeros(3, dtype=np.int64), (8, 8, 8), touches, refine)
    assert [level.width for level in levels] == [1.0, 0.5, 0.25]
    places = []
    for level in levels:
        # Function m has its centre at the lower corner of cell m, less a width.
        index = np.indices(level.active.shape).reshape(3, -1).T + level.low - 1
        places.append(index * level.width @ LINEAR)
    unknowns = np.concatenate([p[level.active.ravel()] for p, level in zip(places, levels, strict=True)])
    matrices, _ = coefficient_matrices(levels)
    for matrix, place, level in zip(matrices[1:], places[1:], levels[1:], strict=True):
        # Functions that touch refined cells alone are not used.
        needed = replace(level, region=level.leaves).touched().ravel()
        assert (matrix @ unknowns)[needed] == pytest.approx(place[needed])


def test_the_linear_system_of_a_chain_of_resistors_has_the_voltages_of_ohm():
    ohms = np.random.default_rng(2).uniform(0.5, 2.0, 30)
    ends = np.zeros((31, 30))
    ends[np.arange(30), np.arange(30)], ends[np.arange(1, 31), np.arange(30)] = -1.0, 1.0
    currents = np.zeros((31, 2))
    currents[[0, 30], 0] = -1.0, 1.0
    currents[[10, 20], 1] = -2.0, 2.0
    found = solve.solve_system(csr_array(ends / ohms @ ends.T), currents)
    assert np.diff(found[:, 0]) == pytest.approx(ohms, rel=1e-6)
    within = (np.arange(30) >= 10) & (np.arange(30) < 20)
    assert np.diff(found[:, 1]) == pytest.approx(2.0 * ohms * within, abs=1e-6)


@pytest.mark.long
def test_progress_of_a_tee_grows_to_the_whole_and_changes_nothing(monkeypatch):
    class Coarse(Junction):
        finest = 0.2

    tee, shown, matrices, solve_system = Coarse(1.0, math.pi / 2, 0.2), [], [], solve.solve_system

    def keep_matrix(matrix, loads, show):
        matrices.append(matrix)
        return solve_system(matrix, loads, show)

    monkeypatch.setattr(solve, "solve_system", keep_matrix)
    monkeypatch.setattr(solve, "describe_errors", lambda *_: "of a grid so coarse they are large")
    for cells in (7, 10_000):
        monkeypatch.setattr(solve, "CELLS", cells)
        with progress.show_progress(lambda what, done, total: shown.append((what, done, total))):
            solve.solve_tee(tee)
    assert shown == [("% of the flow in the tee", done, 100) for done in range(1, 101)] * 2
    # What conjugate gradients make of matrices that differ in their last digits differs by more.
    assert abs(matrices[0] - matrices[1]).max() < 1e-12 * abs(matrices[1]).max()


@pytest.mark.long
def test_the_matrices_of_cut_cells_have_no_energy_for_water_at_rest():
    junction = Junction(0.5, math.pi / 2, 0.1)
    level, wall = solve.make_levels(junction)[0], junction.array()
    corners = (np.argwhere(level.leaves) + level.low) * level.width
    cut = abs(solve._reach_levels(corners + level.width / 2, wall, 0.0)) < 0.3 * level.width
    cells = corners[cut][:20]
    matrices, volumes = cut_stiffness(cells, level.width, wall, 1, *solve._gauss(4), solve.PENALTY)
    # The functions of a cell add up to one: a constant potential, of which the water is at rest.
    assert np.allclose(matrices.sum(axis=2), 0.0, atol=1e-12 * matrices.max())
    assert np.allclose(matrices, matrices.transpose(0, 2, 1), atol=1e-12 * matrices.max())
    assert np.all((volumes > 0.0) & (volumes < level.width**3))
