"""The map of what flights reach."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.errors import InputError
from driftform.motion.path.curve import hermite_coefficients, world_velocity
from driftform.runs.coverage import CoverageMap, PipeGrid, find_passes, map_coverage
from driftform.types import End, Trajectory
from driftform.water import Pipe, Scenario, Segment

PIPE = Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0)


def grid_of(segment, side=None):
    """Return the grid of a straight pipe."""
    return PipeGrid.of_scenario(Scenario(pipe=Pipe(segments=(segment,)), targets={}), side)


CELLS = grid_of(PIPE)
PIECE = 0.1 * CELLS.size.min()

coordinate = st.floats(-10, 10)
points = st.tuples(coordinate, coordinate, coordinate)
segments = (
    st.tuples(points, points, st.floats(0.05, 3))
    .filter(lambda s: np.linalg.norm(np.subtract(s[1], s[0])) > 0.3)
    .map(lambda s: Segment(start=s[0], end=s[1], radius=s[2]))
)


def make_trajectory(t, position, velocity):
    """A flight without rotation: body axes are world axes."""
    still = np.tile([1.0, 0, 0, 0], (len(t), 1))
    return Trajectory(t, position, still, np.hstack([velocity, np.zeros((len(t), 3))]), End.HORIZON)


def straight(start, end, samples=2):
    """A flight of 1 s along a line."""
    t = np.linspace(0.0, 1.0, samples)
    course = np.subtract(end, start)
    return make_trajectory(t, start + t[:, None] * course, np.tile(course, (samples, 1)))


def wild(seed):
    """A flight that winds through the pipe, and out of it, in stretches longer than any real one."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.1, 2.0, 4)) - 0.1
    position = rng.uniform((-0.5, -0.05, -1.2), (3.0, 0.05, 1.2), (4, 3))
    return make_trajectory(t - t[0], position, rng.normal(size=(4, 3)) * (1.0, 0.05, 1.0))


def smooth(seed):
    """A flight that winds through the pipe, with samples as far apart as those of a real one."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 2.0, 41)
    size, rate, phase = (rng.uniform((0.1, 0.01, 0.1), (1.0, 0.08, 1.0)), rng.uniform(0.5, 4, 3), rng.uniform(0, 6, 3))
    angle = np.outer(t, rate) + phase
    drift = np.array([rng.uniform(0.2, 1.0), 0.0, 0.0])
    return make_trajectory(t, size * np.sin(angle) + np.outer(t, drift), size * rate * np.cos(angle) + drift)


seeds = st.integers(0, 2**32 - 1)


def dense(path, n):
    """Points of the path, ``n`` for each stretch."""
    curve = hermite_coefficients(path.t, path.position, world_velocity(path))
    u = np.linspace(0, 1, n)[:, None] ** np.arange(4)
    return np.vstack([u @ cubic for cubic in curve])


@given(segments, st.floats(0.05, 1))
def test_the_cells_fill_the_section_of_any_pipe(segment, side):
    cells = grid_of(segment, side)
    length = np.linalg.norm(np.subtract(segment.end, segment.start))
    assert cells.size[0] * cells.shape[0] == pytest.approx(length)
    assert cells.size[1] * cells.shape[1] == pytest.approx(2 * segment.radius)
    assert len(cells.centres()) == cells.cell_count
    for extent, size in zip((length, 2 * segment.radius), cells.size, strict=False):
        # As near to the side as a whole number of cells allows.
        assert round(extent / side) in (0, round(extent / size))


@pytest.mark.parametrize(
    ("length", "radius", "shape", "size"),
    [(9.0, 1.0, (90, 20), (0.1, 0.1)), (30.0, 0.15, (1000, 10), (0.03, 0.03)), (0.4, 2.0, (2, 20), (0.2, 0.2))],
)
def test_by_default_cells_are_a_tenth_of_the_radius_but_not_over_a_thousand_along_the_pipe(length, radius, shape, size):
    cells = grid_of(Segment(start=(0.0, 0.0, 0.0), end=(length, 0.0, 0.0), radius=radius))
    assert cells.shape == shape
    assert cells.size[:2] == pytest.approx(size)


@given(segments)
def test_the_axes_of_the_map_are_right_handed_and_its_plane_is_vertical(segment):
    cells = grid_of(segment)
    along, up, aside = cells.axes
    np.testing.assert_allclose(cells.axes @ cells.axes.T, np.eye(3), atol=1e-12)
    # As x, y and z are.
    np.testing.assert_allclose(np.cross(along, aside), up, atol=1e-12)
    steep = abs(along[2]) > 1 - 1e-12
    assert steep or (up[2] > 0 and abs(aside[2]) < 1e-9)


@given(segments)
def test_the_centre_of_every_cell_is_in_it_and_goes_to_the_world_and_back(segment):
    cells = grid_of(segment, 0.2)
    centres = cells.to_world(cells.centres())
    np.testing.assert_array_equal(cells._cell_at(cells._place(centres)), np.arange(cells.cell_count))
    np.testing.assert_allclose(cells.to_map(centres)[:, :2], cells.centres(), atol=1e-12)
    assert all(Pipe(segments=(segment,)).contains(tuple(centre)) for centre in centres[:: cells.cell_count // 5 + 1])


ELBOW_AND_TEE = Pipe(
    radius=0.5,
    parts=(
        {"kind": "straight", "length": 3.0},
        {"kind": "bend", "radius": 2.0, "roll_deg": 180.0},
        {"kind": "reducer", "radius": 0.3, "length": 0.5},
        {
            "kind": "tee",
            "branch_radius": 0.2,
            "share": 0.3,
            "roll_deg": 0.0,
            "branch": [
                {"kind": "straight", "length": 0.5},
                {"kind": "bend", "radius": 0.5, "angle_deg": 57.29578, "outlet": "a"},
            ],
        },
        {"kind": "bend", "radius": 1.0, "roll_deg": 90.0},
        {"kind": "straight", "length": 1.0, "outlet": "b"},
    ),
)


def test_a_map_of_parts_goes_to_the_world_and_back():
    cells = PipeGrid.of_scenario(Scenario(pipe=ELBOW_AND_TEE, targets={}))
    centres = cells.centres()
    world = cells.to_world(centres)
    there = np.isfinite(world).all(axis=1)
    # Only the columns between the run and the branch are nowhere.
    assert 0 < np.count_nonzero(~there) < 0.03 * len(there)
    layout = cells.layout
    inside = layout.find_part(world[there]) >= 0
    back = cells.to_map(world[there][inside])
    same = np.abs(back[:, :2] - centres[there][inside]).max(axis=1) < 1e-9
    # Around the tee a point belongs to the run or to the branch, whose maps overlap there.
    tee = layout.parts[3].part
    from_tee = np.linalg.norm(world[there][inside][~same] - tee.origin, axis=1)
    assert same.mean() > 0.9 and from_tee.max() < 2.5 * tee.radius
    assert back[same, 2] == pytest.approx(0, abs=1e-9)


def test_the_axis_of_a_map_of_parts_leads_from_the_inlet_to_every_outlet():
    cells = PipeGrid.of_scenario(Scenario(pipe=ELBOW_AND_TEE, targets={}))
    x = np.linspace(0, cells.size[0] * cells.shape[0], 5000)
    axis = cells.to_world(np.column_stack([x, np.zeros(len(x))]))
    axis = axis[np.isfinite(axis).all(axis=1)]
    for opening in (cells.layout.inlet, *(outlet.opening for outlet in cells.layout.outlets)):
        assert np.linalg.norm(axis - opening.centre, axis=1).min() < 0.003
    # One step is one step in the pipe, but for the one from the outlet of the run to the branch.
    steps = np.sort(np.linalg.norm(np.diff(axis, axis=0), axis=1))
    assert steps[:-1] == pytest.approx(x[1], rel=0.01)
    assert steps[-1] > 0.5


@settings(deadline=None, max_examples=40)
@given(st.builds(wild, seeds) | st.builds(smooth, seeds))
def test_a_flight_crosses_the_cells_that_a_dense_row_of_its_points_lies_in(path):
    crossed, _ = CELLS.find_crossed(path)
    row = dense(path, 400)
    gap = np.linalg.norm(np.diff(row, axis=0), axis=1).max()
    cells, points = np.unique(CELLS._cell_at(CELLS._place(row)), return_counts=True)
    seen = set(cells.tolist()) - {-1}
    # The path is cut into pieces of a tenth of a cell: a corner may be stepped over.
    long = set(cells[points * gap > 10 * PIECE].tolist()) - {-1}
    assert long <= set(crossed.tolist())
    place = CELLS.to_map(row)[:, :2]
    for cell in set(crossed.tolist()) - seen:
        outside = np.maximum(np.abs(place - CELLS.centres()[cell]) - CELLS.size[:2] / 2, 0)
        assert np.linalg.norm(outside, axis=1).min() < max(gap, PIECE)


@settings(deadline=None, max_examples=40)
@given(st.builds(smooth, seeds))
def test_the_distance_in_a_cell_is_that_of_the_nearest_point_inside(path):
    crossed, distance = CELLS.find_crossed(path)
    row = dense(path, 200)
    cell_of_point = CELLS._cell_at(CELLS._place(row))
    gap = np.linalg.norm(np.diff(row, axis=0), axis=1).max()
    for cell, found in zip(crossed, distance, strict=True):
        inside = row[cell_of_point == cell]
        assert found <= np.linalg.norm(CELLS.size) / 2 + PIECE
        if len(inside):
            least = np.linalg.norm(inside - CELLS.to_world(CELLS.centres()[[cell]]), axis=1).min()
            # Pieces are straight, and each is in the cell of its middle; far from the sides that does not matter.
            assert found == pytest.approx(least, abs=gap + (1e-4 if least < 0.03 else PIECE))


def test_a_flight_on_the_side_between_two_cells_is_in_the_upper_one_alone():
    crossed, distance = CELLS.find_crossed(straight((0.0, 0.0, 0.0), (8.99, 0.0, 0.0)))
    np.testing.assert_allclose(CELLS.centres()[crossed, 1], 0.05)
    np.testing.assert_allclose(distance, 0.05)


def test_a_flight_is_credited_only_where_it_is_in_the_plane():
    crossed, _ = CELLS.find_crossed(straight((0.0, -1.0, 0.25), (9.0, 1.0, 0.25)))
    along = CELLS.centres()[crossed, 0]
    # It is within half a cell of the plane from x = 4.275 to 4.725.
    np.testing.assert_allclose(along, [4.25, 4.35, 4.45, 4.55, 4.65, 4.75])


def test_what_lies_upstream_of_the_inlet_or_past_the_outlet_is_not_on_the_map():
    crossed, _ = CELLS.find_crossed(straight((-3.0, 0.0, 0.25), (12.0, 0.0, 0.25)))
    assert len(crossed) == 90
    assert len(CELLS.find_crossed(straight((9.5, 0.0, 0.0), (12.0, 0.0, 0.0)))[0]) == 0


def test_a_flight_of_a_single_sample_is_in_the_cell_of_its_point():
    crossed, distance = CELLS.find_crossed(
        make_trajectory(np.zeros(1), np.array([[0.12, 0.01, 0.02]]), np.ones((1, 3)))
    )
    np.testing.assert_allclose(CELLS.centres()[crossed], [[0.15, 0.05]])
    np.testing.assert_allclose(distance, np.linalg.norm([0.03, 0.01, 0.03]))
    assert len(CELLS.find_crossed(make_trajectory(np.zeros(1), np.array([[-1.0, 0, 0]]), np.ones((1, 3))))[0]) == 0


@settings(deadline=None, max_examples=40)
@given(st.builds(smooth, seeds), st.floats(0, 2 * np.pi), st.floats(-1, 1))
def test_a_pipe_that_lies_elsewhere_has_the_same_map(path, heading, slope):
    along = np.array([np.cos(heading) * np.cos(slope), np.sin(heading) * np.cos(slope), np.sin(slope)])
    aside = np.array([-np.sin(heading), np.cos(heading), 0.0])
    turn = np.column_stack([along, aside, np.cross(along, aside)])
    shift = np.array([3.0, -2.0, 0.5])
    segment = Segment(start=tuple(shift), end=tuple(shift + 9 * along), radius=1.0)
    # Velocities are turned by the body's attitude, which stays: as if they were given in world axes.
    moved = make_trajectory(path.t, path.position @ turn.T + shift, path.velocity[:, :3] @ turn.T)
    cells, distance = CELLS.find_crossed(path)
    again, there = grid_of(segment).find_crossed(moved)
    both, here, yonder = np.intersect1d(cells, again, return_indices=True)
    np.testing.assert_allclose(distance[here], there[yonder], atol=1e-9)
    # What is touched in a corner alone may differ by rounding.
    assert len(both) >= max(len(cells), len(again)) - 2


def test_each_cell_keeps_the_closest_flight_and_counts_all():
    reach = map_coverage(
        [
            (3, straight((0.0, 0.0, 0.26), (9.0, 0.0, 0.26))),
            (5, straight((0.0, 0.0, 0.25), (4.5, 0.0, 0.25))),
            (8, straight((0.0, 0.0, 0.25), (9.0, 0.0, 0.25))),
            (9, straight((0.0, 0.0, -0.35), (0.95, 0.0, -0.35))),
        ],
        CELLS,
    )
    row = CELLS._cell_at(CELLS._place(np.array([[x, 0.0, 0.25] for x in (0.05, 4.45, 4.55, 8.95)])))
    assert reach.evaluation[row].tolist() == [5, 5, 8, 8]
    assert reach.visits[row].tolist() == [3, 3, 2, 2]
    np.testing.assert_allclose(reach.distance[row], 0, atol=1e-12)
    assert np.count_nonzero(reach.reached) == 90 + 10
    assert reach.flights == 4
    assert (reach.evaluation[~reach.reached] == -1).all() and np.isinf(reach.distance[~reach.reached]).all()


def test_adding_a_flight_returns_where_it_is_the_closest_now():
    reach = CoverageMap(CELLS)
    level = straight((0.0, 0.0, 0.25), (9.0, 0.0, 0.25))
    assert len(reach.add(0, level)) == 90
    assert len(reach.add(1, level)) == 0
    # This one crosses the same row from x = 2.25 to 6.75, off its middle but for one place.
    taken = reach.add(2, straight((0.0, 0.0, 0.15), (9.0, 0.0, 0.35)))
    assert sorted(set(CELLS.centres()[taken, 1].round(6))) == [0.15, 0.35]
    assert reach.evaluation[taken].tolist() == [2] * len(taken)


def test_open_water_has_no_map():
    with pytest.raises(InputError, match="needs a pipe"):
        PipeGrid.of_scenario(Scenario())


def test_passes_are_sorted_by_their_distance_the_earliest_of_equals_first():
    level = straight((0.0, 0.0, 0.3), (9.0, 0.0, 0.3), samples=4)
    far = replace(straight((0.0, 0.0, 0.9), (9.0, 0.0, 0.9)), error=1e-4)
    passes = find_passes(iter([(2, far), (4, level), (7, level)]), (4.5, 0.0, 0.0))
    assert [found.evaluation for found in passes] == [4, 7, 2]
    assert [found.distance for found in passes] == pytest.approx([0.3, 0.3, 0.9])
    assert passes[0].t == pytest.approx(0.5)
    assert [found.checked for found in passes] == [False, False, True]
    assert find_passes([], (0.0, 0.0, 0.0)) == []


def test_a_map_counts_its_flights_and_those_without_an_estimate_of_their_error():
    flight = straight((0.0, 0.0, 0.3), (9.0, 0.0, 0.3))
    reach = map_coverage([(0, flight), (1, replace(flight, error=0.0)), (2, flight)], CELLS)
    assert (reach.flights, reach.unchecked) == (3, 2)


def test_a_flight_around_a_bend_crosses_the_cells_along_its_axis():
    cells, layout = PipeGrid.of_scenario(Scenario(pipe=ELBOW_AND_TEE, targets={})), ELBOW_AND_TEE.layout
    points = np.concatenate([placed.part.list_axes(0.01)[0].points[:-1] for placed in layout.parts[:2]])
    t = np.linspace(0, 1, len(points))
    velocity = np.zeros((len(t), 6))
    velocity[:, :3] = np.gradient(points, t, axis=0)
    path = Trajectory(t, points, np.tile([1.0, 0, 0, 0], (len(t), 1)), velocity, End.HORIZON)
    crossed, distance = cells.find_crossed(path)
    columns = np.unique(crossed // cells.shape[1])
    assert columns.tolist() == list(range(int(layout.depths[2] / cells.size[0])))
    assert distance.max() < np.linalg.norm(cells.size) / 2
