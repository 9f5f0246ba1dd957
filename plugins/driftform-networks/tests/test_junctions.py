"""What a network says of pipes and corners, in closed form; and what is kept of networks and flights."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import driftform
from driftform.errors import WorkFailedError
from driftform.types import End
from driftform.water import Scenario
from driftform_networks.flights.bodies import FLOWN_BY, open_traveller
from driftform_networks.flights.bore import (
    BANDS,
    MIXED,
    divide_bore,
    find_band,
    sample_band,
    smallest_share,
    spread_points,
)
from driftform_networks.flights.fits import find_obstacle, longest_rod
from driftform_networks.flights.junctions import describe_junction, find_bends
from driftform_networks.flights.straight import StraightFlights, StraightTask, fly
from driftform_networks.flights.travelling import repeat_cells
from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.hydraulics.network import take_snapshot
from driftform_networks.passages.passage import find_reachable
from driftform_networks.planning.choosing import bound_steering


@pytest.fixture(scope="module")
def sphere():
    return open_traveller("sphere:60mm")


def draw_fork(fork_file, side=100.0):
    """The fork with another length of its side, m; drawn are 200, 200 and 100."""
    network = open_network(fork_file)
    assert network.links == ("main", "on", "side")
    return replace(network, length=np.array([200.0, 200.0, side]))


@given(st.floats(0.1, 2), st.floats(0.1, 2))
def test_the_longest_rod_around_a_right_angle_is_that_of_the_ladder(first, second):
    ladder = (first ** (2 / 3) + second ** (2 / 3)) ** 1.5
    assert longest_rod(first, second, np.pi / 2, 0.0) == pytest.approx(ladder, rel=1e-5)
    assert longest_rod(first, second, 0.0, 0.05) == np.inf and longest_rod(first, second, np.pi / 2, 2.0) == 0.0


@given(st.floats(0.0, 0.9), st.floats(0.1, 2.8))
def test_a_wide_rod_between_equal_bores_passes_the_corner_at_its_middle(width, turn):
    """In the middle the rod lies across the bisector, at which its outer side is as far from the corner as its inner side from the edge."""
    half = (np.pi - turn) / 2
    middle = 2 * (1 / np.sin(half) - width) * np.tan(half)
    assert longest_rod(1.0, 1.0, turn, width) <= middle * (1 + 1e-9)
    if turn <= np.pi / 2:
        assert longest_rod(1.0, 1.0, turn, width) == pytest.approx(middle, rel=1e-5)


def test_a_body_that_is_as_long_as_the_corner_allows_passes_and_a_longer_one_does_not(sphere):
    body = sphere.agent.body
    assert find_obstacle(body, 0.1, 0.059, 0.0) == "too wide: 60 mm in a bore of 59 mm"
    # A sphere passes where the rod around it does, which is as long as it is wide.
    for bore, passes in ((0.064, True), (0.063, False)):
        longest = 2 * np.sqrt(2) * bore - 2 * 0.06
        assert (longest > 0.06) == passes
        found = find_obstacle(body, bore, bore, np.pi / 2)
        if passes:
            assert found == ""
        else:
            assert found.startswith("too long: 60 mm, and a turn of 90 degrees")
            assert found.endswith(f"lets {1000 * longest:.0f} mm pass")


@pytest.mark.parametrize("side", [100.0, 200.0])
def test_the_fork_is_a_tee_with_a_branch_at_the_right(side, fork_file):
    """Also where a side of 200 m is drawn with 100, so that the map says nothing about angles."""
    network = draw_fork(fork_file, side)
    assert network.scale == (pytest.approx(1) if side == 100 else None)
    snapshot = take_snapshot(network)
    main = network.links.index("main")
    junction = describe_junction(snapshot, main, "side")
    assert junction.bore == pytest.approx(0.3)
    assert junction.bores == pytest.approx([0.3, 0.3])
    assert junction.shares == pytest.approx([2 / 3, 1 / 3])
    assert junction.exit == 0
    assert junction.turns == pytest.approx([0, np.pi / 2])
    assert junction.directions == pytest.approx(np.array([[0, 0], [1, 0]]))
    top, bottom = (describe_junction(snapshot, main, side).directions[1] for side in ("top", "bottom"))
    assert top == pytest.approx([0, 1])
    assert bottom == pytest.approx([0, -1])


def test_the_bends_of_a_pipe_are_the_angles_between_its_parts(fork_file):
    """From (0, 0) to (200, 0) over (50, 50) and (100, 0): 141 m, and 100 m on."""
    network = draw_fork(fork_file)
    points = np.array([[50.0, 50.0], [100.0, 0.0]])
    length = np.array([100 * np.sqrt(2) + 100, 200, 100])
    bent = replace(network, vertices=(points, *network.vertices[1:]), length=length)
    turns, places = find_bends(bent, 0)
    assert np.rad2deg(turns) == pytest.approx([90, -45])
    assert places == pytest.approx(np.array([1, 2]) * 50 * np.sqrt(2) / length[0])
    assert len(find_bends(bent, 1)[0]) == 0
    # A map that is not to scale says nothing about bends.
    unknown = replace(bent, length=10 * length * [1, 5, 9])
    assert len(find_bends(unknown, 0)[0]) == 0


@pytest.mark.parametrize(("reverse", "side"), [(False, 1), (True, -1)])
def test_right_and_left_are_those_of_the_way_of_the_water(reverse, side, fork_file):
    """Water from the west finds the branch to the south at its right, and water from the east at its left."""
    network = draw_fork(fork_file)
    if reverse:
        flow = network.hydraulics.flow * [-1, -1, 1]
        network = replace(network, hydraulics=replace(network.hydraulics, flow=flow))
    snapshot = take_snapshot(network)
    inlet = int(np.flatnonzero(snapshot.head == network.find_node("fork"))[0])
    outlets = snapshot.links[snapshot.outlets[network.find_node("fork")]]
    directions = describe_junction(snapshot, inlet, "side").directions
    assert directions[outlets == network.links.index("side")] == pytest.approx(np.array([[side, 0]]))


@given(st.floats(0.02, 0.98))
def test_a_flat_surface_divides_the_bore_by_a_segment_of_the_circle(share):
    """Its distance from the wall is the size at which a sphere can enter no smaller branch."""
    points = np.column_stack([np.linspace(-1, 1, 2001), np.zeros(2001)])
    entered = divide_bore(points, np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([1 - share, share]))[:, 1]
    edge = points[entered > 0, 0].min()
    if share < 0.5:
        assert smallest_share(1 - edge) == pytest.approx(share, abs=6e-3)
    assert (entered[points[:, 0] > edge] == 1).all()


@given(cells=st.integers(1, 40), seed=st.integers(0, 2**32 - 1))
def test_a_run_of_cells_is_the_power_of_one(sphere, cells, seed):
    rng = np.random.default_rng(seed)
    transfer = rng.dirichlet(np.ones(BANDS), BANDS) * rng.uniform(0.9, 1, (BANDS, 1))
    slowness = rng.uniform(1, 3, BANDS)
    scatter = rng.uniform(0, 0.1, BANDS)
    flights = StraightFlights(2.0, transfer, slowness, scatter, np.zeros((0, 13)))
    task = StraightTask(sphere, Path(), 0.3, 0.5, 0.0)
    table = repeat_cells(flights, cells, task)
    assert table.transfer == pytest.approx(np.linalg.matrix_power(transfer, cells))
    spent = sum(np.linalg.matrix_power(transfer, cell) @ slowness for cell in range(cells))
    assert table.slowness == pytest.approx(spent / cells)
    spread = sum(np.linalg.matrix_power(transfer, cell) @ scatter for cell in range(cells))
    assert table.scatter == pytest.approx(spread / cells**2)
    assert table.obstacle == "at rest on the wall: 300 mm, about 0.5 m/s"


@pytest.mark.parametrize("room", [0.3, 1.0])
def test_points_of_a_band_are_found_in_it_and_bands_have_equal_areas(room):
    numbers = np.random.default_rng(0).random((200, 2))
    for band in range(BANDS):
        assert (find_band(sample_band(band, room, numbers), room) == band).all()
    found = np.bincount(find_band(spread_points(room), room), minlength=BANDS)
    assert found / found.sum() == pytest.approx(MIXED)


def test_a_steered_body_sees_the_main_and_one_branch_of_a_fork_and_two_see_all(fork_file):
    network = open_network(fork_file)
    snapshot, source = take_snapshot(network), network.find_node("source")
    reachable = find_reachable(network, source, [0])
    assert bound_steering([[snapshot]], [source], reachable, 1) == pytest.approx(2 / 3)
    assert bound_steering([[snapshot]], [source], reachable, 2) == pytest.approx(1)


@pytest.mark.parametrize(
    "damage",
    [None, lambda whole: whole[:-9], lambda _: b"PK\5\6" + bytes(18)],
    ids=["sound", "cut", "an empty archive"],
)
def test_a_network_from_the_cache_is_the_one_that_was_computed(fork_file, tmp_path, capsys, damage):
    computed = open_network(fork_file, tmp_path)
    copy = tmp_path / "other.inp"
    copy.write_bytes(fork_file.read_bytes())
    [file] = tmp_path.glob("*.npz")
    if damage:
        file.write_bytes(damage(file.read_bytes()))
    kept = open_network(copy, tmp_path)
    assert list(tmp_path.glob("*.npz")) == [file]
    assert capsys.readouterr().err.count(f"{file} is damaged (") == bool(damage)
    assert (computed.name, kept.name) == ("fork", "other")
    for one, two in ((computed, replace(kept, name="fork")), (computed.hydraulics, kept.hydraulics)):
        for name, value in vars(one).items():
            again = getattr(two, name)
            assert type(again) is type(value)
            if name == "vertices":
                assert all(np.array_equal(a, b) for a, b in zip(again, value, strict=True))
            elif name != "hydraulics":
                assert np.array_equal(again, value), name


def test_the_code_that_decides_flights_is_where_its_hash_looks_for_it():
    core = Path(driftform.__file__).parent
    assert all(list((core / name).glob("*.py")) for name in FLOWN_BY)


def test_a_flight_that_has_taken_all_its_steps_counts_and_one_that_broke_off_does_not(sphere, monkeypatch):
    scenario = Scenario.model_validate(sphere.scenario.model_dump() | {"flight": {"horizon": 1.0}})
    [whole] = fly(sphere, [scenario], "in a pipe")
    assert whole is not None and not whole.end.failed
    ends = [End.STEP_LIMIT, End.NON_FINITE]
    monkeypatch.setattr(
        type(sphere.simulator),
        "screen_batch",
        lambda _, agents, *__: [replace(whole, end=end) for end in ends[: len(agents)]],
    )
    held, broken = fly(sphere, [scenario] * 2, "in a pipe")
    assert held is not None and held.end is End.STEP_LIMIT and broken is None
    ends.reverse()
    with pytest.raises(WorkFailedError, match="cannot be flown in a pipe"):
        fly(sphere, [scenario], "in a pipe")
