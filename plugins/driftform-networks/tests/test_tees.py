"""Which junctions are flown through, by which tees, and that their tables say what flights do."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform_networks.flights.bodies import open_traveller
from driftform_networks.flights.bore import BANDS, BOTTOM, MIRROR, RIGHT, TOP, find_band, smallest_share, spread_points
from driftform_networks.flights.junctions import Junction
from driftform_networks.flights.straight import StraightFlights
from driftform_networks.flights.tees import (
    BRANCH,
    RATIOS,
    RUN,
    SHARES,
    Tee,
    TeeFlights,
    TeeTask,
    find_branches,
    find_joint,
    fly_tee,
    match_ratio,
    weigh_shares,
)
from driftform_networks.flights.travelling import Travel, Traveling
from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.hydraulics.network import take_snapshot
from driftform_networks.passages.passage import count_passings
from driftform_networks.passages.routing import JOINT, TEE
from driftform_networks.planning.following import route

FORK = Path(__file__).with_name("fork.inp").read_text()

CALM = ("flow.kind=log_law",)
"""Without gusts."""


def make_junction(**changes):
    """A tee with a branch at the left that takes a third of the water."""
    usual = {
        "bore": 0.3,
        "bores": np.array([0.3, 0.2]),
        "shares": np.array([2 / 3, 1 / 3]),
        "exit": 0.0,
        "directions": np.array([[0.0, 0.0], [-1.0, 0.0]]),
        "turns": np.array([0.0, np.pi / 2]),
        "stores": False,
        "inlets": 1,
        "offtake": 0.02,
    }
    return Junction(**usual | changes)


@given(share=st.floats(SHARES[0], SHARES[-1]))
def test_the_shares_around_one_have_it_as_their_mean(share):
    found = weigh_shares(share, 0.0)
    assert sum(weight for _, weight in found) == pytest.approx(1)
    assert sum(step * weight for step, weight in found) == pytest.approx(share, abs=1e-5)


@given(size=st.floats(0.01, 0.95), part=st.floats(0.0, 0.999))
def test_nothing_enters_an_outlet_below_the_smallest_share_of_streamtubes(size, part):
    share = part * smallest_share(size)
    assert weigh_shares(share, size) == [(0.0, 1.0)]
    assert weigh_shares(1 - share, size) == [(1.0, 1.0)]


@given(ratio=st.floats(0.2, 1.0), size=st.floats(0.01, 0.9), angle=st.sampled_from(sorted(RATIOS)))
def test_a_body_that_fits_into_a_branch_fits_into_the_one_that_stands_for_it(ratio, size, angle):
    assert size > ratio or size < match_ratio(ratio, size, RATIOS[angle])


@pytest.mark.parametrize("angle", sorted(RATIOS))
def test_the_flow_in_every_tee_that_stands_for_others_comes_with_driftform(angle):
    from driftform.water.parts.tee_store import PACKAGED, file_name
    from driftform.water.parts.tee_wall import Junction

    for ratio in RATIOS[angle]:
        shape = Junction(ratio, np.deg2rad(min(angle, 180 - angle)), round(0.2 * ratio, 9))
        assert (PACKAGED / file_name(shape)).is_file()


CROSS = {
    "bores": np.array([0.2, 0.3, 0.15]),
    "shares": np.array([0.2, 0.5, 0.3]),
    "directions": np.array([[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0]]),
    "turns": np.array([1.5, 0.0, 1.5]),
}


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"inlets": 2}, "join"),
        ({"bore": 0.0}, "no bore upstream"),
        ({"bores": np.array([0.3, 0.32])}, "wide branch"),
        ({"bores": np.array([0.3, 0.05])}, "narrow branch"),
        ({"turns": np.array([0.0, np.deg2rad(150)])}, "steep branch"),
        ({"directions": np.array([[1.0, 0.0], [-1.0, 0.0]])}, "no straight run"),
        ({name: np.concatenate([part, part[:1]]) for name, part in CROSS.items()}, "more branches"),
    ],
)
def test_streamtubes_divide_what_is_no_tee_of_the_core_and_the_reason_is_named(changes, reason):
    assert find_branches(make_junction()) == ([1], "")
    assert find_branches(make_junction(**changes)) == ([], reason)


def test_a_cross_is_two_tees_in_a_row_the_larger_branch_first(tmp_path):
    """Of all bodies the first takes 0.4, mirrored to the left, and of the others the second 0.5."""
    cross, sphere = make_junction(**CROSS), open_traveller("sphere:60mm")
    assert find_branches(cross) == ([2, 0], "")
    traveling = Traveling(sphere, Travel(), tmp_path)
    first, second = (TeeTask(sphere, tmp_path, Tee(0.3, 0.5, 0.5, 90.0, 90.0, share), None) for share in (0.3, 0.5))
    onward = {name: np.zeros((BANDS, 2, BANDS)) for name in (0.3, 0.5)}
    onward[0.3][:, BRANCH, RIGHT], onward[0.3][:, RUN, TOP] = 0.4, 0.5
    onward[0.5][:, BRANCH, BOTTOM], onward[0.5][:, RUN, RIGHT] = 0.5, 0.25
    traveling._read_tee = lambda task: TeeFlights(onward[task.tee.share], 0.0)  # type: ignore[assignment]
    found = traveling._fly_on(cross, [(2, [(first, 1.0)]), (0, [(second, 1.0)])])
    assert found[0].sum(axis=1) == pytest.approx([0.5 * 0.5, 0.5 * 0.25, 0.4])
    left = MIRROR[RIGHT]
    assert (found[0, 2, left], found[0, 0, BOTTOM], found[0, 1, RIGHT]) == pytest.approx((0.4, 0.25, 0.125))


def test_no_body_enters_a_branch_that_takes_too_little_water(tmp_path):
    sphere = open_traveller("sphere:60mm")
    task = TeeTask(sphere, tmp_path, Tee(0.3, 0.5, 0.5, 90.0, 90.0, 0.0), None)
    found = Traveling(sphere, Travel(), tmp_path)._fly_on(make_junction(), [(1, [(task, 1.0)])])
    assert found is not None and not found[:, 1].any()
    assert found[:, 0] == pytest.approx(np.eye(BANDS))


def test_two_pipes_that_meet_are_a_bend_and_a_reducer_or_neither():
    def meet(bore, turn, **changes):
        one = {"bores": np.array([bore]), "shares": np.ones(1), "turns": np.deg2rad([turn])}
        return make_junction(**one | {"directions": np.array([[1.0, 0.0]])} | changes)

    assert find_joint(meet(0.3, 5.0), 0.1) == (0.0, 1.0)
    assert find_joint(meet(0.2, 50.0), 0.1) == (45.0, 0.7)
    assert find_joint(meet(0.5, 0.0), 0.1) == (0.0, 1.4)
    # It fits into 170 mm, but not into half of 300 mm.
    assert find_joint(meet(0.17, 0.0), 0.1) == (0.0, 0.5)
    assert find_joint(meet(0.17, 0.0), 0.52) == (0.0, 0.7)
    assert find_joint(meet(0.2, 50.0, inlets=2), 0.1) == (0.0, 1.0)
    # It fits into neither.
    assert match_ratio(0.55, 0.7, RATIOS[90.0]) == 0.5


@pytest.mark.parametrize("reverse", [False, True])
def test_bends_within_a_link_move_bodies_between_its_runs(reverse, fork_file, tmp_path):
    """A right angle to the left after a third of the way, and half of one to the right after two thirds; or backwards."""
    network = open_network(fork_file, tmp_path)
    places, points = network.places.copy(), np.array([[100.0, 0.0], [100.0, 100.0]])
    places[network.find_node("source")], places[network.find_node("fork")] = (0.0, 0.0), (170.71, 170.71)
    length = np.array([300.0, *np.linalg.norm(places[[1, 2]] - places[0], axis=1)])
    flow = network.hydraulics.flow * (-1 if reverse else 1)
    bent = replace(
        network,
        places=places,
        length=length,
        vertices=(points, *network.vertices[1:]),
        hydraulics=replace(network.hydraulics, flow=flow),
    )
    heavy = open_traveller("sphere:60mm", buoyancy=-0.1)
    traveling, snapshot = Traveling(heavy, Travel(), tmp_path), take_snapshot(bent)
    [link] = np.flatnonzero(snapshot.links == 0).tolist()
    bends = traveling._list_bends(snapshot, link)
    expected = [(1 / 3, 90.0, True), (2 / 3, 45.0, False)]
    # From the other end, a body meets them in the other order, and turns to the other side.
    expected = [(1 - place, angle, not left) for place, angle, left in expected[::-1]] if reverse else expected
    found = [(place, task.tee.angle_deg, left) for place, task, left in bends]
    assert np.array(found) == pytest.approx(np.array(expected), abs=1e-4)
    shift = np.roll(np.eye(BANDS), 1, axis=1)
    onward = np.zeros((BANDS, 2, BANDS))
    onward[:, RUN] = shift
    traveling._read_tee = lambda task: TeeFlights(onward, 0.0)  # type: ignore[assignment]
    cell = np.roll(0.9 * np.eye(BANDS), 3, axis=1)
    flights = StraightFlights(10.0, cell, np.full(BANDS, 1.5), np.full(BANDS, 0.2), np.zeros((0, 13)))
    table = traveling._run_along(flights, 3, bends, bends[0][1].straight)
    # Either way, the first bend leads to the left.
    assert table.transfer == pytest.approx(cell @ shift[MIRROR][:, MIRROR] @ cell @ shift @ cell)
    assert table.slowness == pytest.approx(1.5 * (1 + 0.9 + 0.81) / 3)
    assert table.scatter == pytest.approx(0.2 * (1 + 0.9 + 0.81) / 9)


@pytest.mark.long
@pytest.mark.parametrize(("turn", "ratio"), [(90.0, 1.0), (22.5, 1.4), (0.0, 0.5)])
def test_small_neutral_bodies_keep_their_band_in_bends_and_reducers(turn, ratio):
    """The streamlines of the ideal flow in a bend are concentric, and those of a reducer scale with its bore."""
    states = np.zeros((BANDS, 13))
    for band in range(BANDS):
        clock, away = (band - 1) * np.pi / 4, 0.6 * (band > 0)
        states[band] = [band, away * np.sin(clock), away * np.cos(clock), 1, 0, 0, 0, 0.5, 0, 0, 0, 0, 0]
    found = fly_tee(open_traveller("sphere:4mm", None, CALM), Tee(0.2, 0.5, ratio, turn, 90.0, None), states)
    assert found.failed == 0
    assert found.onward[:, RUN] == pytest.approx(np.eye(BANDS))


def test_fittings_are_counted_once_for_all_members_and_flights_come_first():
    one, two = {1: TEE, 2: "join", 3: "join"}, {1: "join", 2: TEE, 4: JOINT}
    assert count_passings([one, two]) == {"flown": {TEE: 2, JOINT: 1}, "streamtubes": {"join": 1}}


def test_the_mirror_image_of_a_band_is_that_of_its_points():
    points = spread_points(1.0)
    assert np.array_equal(MIRROR[find_band(points, 1.0)], find_band(points * [-1, 1], 1.0))


def test_a_neutral_sphere_enters_a_branch_alike_on_every_side():
    """A sphere beside the branch enters it, and keeps its band as seen in the branch; one on the opposite side stays in the run."""
    sphere, entered = open_traveller("sphere:20mm", None, CALM), []
    for clock, side in ((0.0, TOP), (90.0, RIGHT), (180.0, BOTTOM)):
        other = (side + 3) % 8 + 1
        states = np.zeros((2, 13))
        for row, band in enumerate((side, other)):
            turn = (band - 1) * np.pi / 4
            states[row] = [band, 0.8 * np.sin(turn), 0.8 * np.cos(turn), 1, 0, 0, 0, 0.5, 0, 0, 0, 0, 0]
        found = fly_tee(sphere, Tee(0.2, 0.5, 1.0, 90.0, clock, 0.3), states)
        assert found.failed == 0
        assert found.onward[other, RUN, other] == 1
        entered.append(found.onward[side, BRANCH])
    assert all(bands.sum() == 1 and np.array_equal(bands, entered[0]) for bands in entered)


def test_a_wide_sphere_sees_less_of_a_slow_branch_than_water(fork_file, call, tmp_path):
    network = open_network(fork_file, tmp_path)
    branch = network.find_node("branch")
    spheres = (replace(open_traveller(f"sphere:{size}mm"), error=0.0) for size in (20, 80))
    narrow, wide = (route(network, sphere, "source", cache=tmp_path) for sphere in spheres)
    fork = network.find_node("fork")
    assert narrow.passings == {fork: "narrow body"}
    assert wide.passings == {fork: TEE}
    assert wide.probability[branch] < narrow.probability[branch] - 0.02
    assert sum(end.probability for end in wide.ends) == pytest.approx(1)
    result = call("route", fork_file, "sphere:80mm", "--release", "source", "--buoyancy-error", 0, "--cache", tmp_path)
    assert "flown through 1 tees and crosses; streamtubes divide bodies at 0" in result.stdout
