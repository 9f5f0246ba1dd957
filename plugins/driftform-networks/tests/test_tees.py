"""Which junctions are flown through, by which tees, and that their tables say what flights do."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform_networks.api import route
from driftform_networks.bodies import open_traveller
from driftform_networks.bore import BANDS, BOTTOM, MIRROR, RIGHT, TOP, find_band, spread_points
from driftform_networks.dividing import divide_bodies
from driftform_networks.junctions import Junction
from driftform_networks.passage import count_passings
from driftform_networks.reading import open_network
from driftform_networks.routing import TEE
from driftform_networks.streamtubes import smallest_share
from driftform_networks.tee_flights import fly_tee
from driftform_networks.tees import BRANCH, RATIOS, RUN, SHARES, Tee, find_branches, match_ratio, weigh_shares


def make_junction(**changes: Any) -> Junction:
    """A tee with a branch at the left that takes a third of the water."""
    usual: dict[str, Any] = {
        "bore": 0.3,
        "bores": np.array([0.3, 0.2]),
        "shares": np.array([2 / 3, 1 / 3]),
        "exit": 0.0,
        "directions": np.array([[0.0, 0.0], [-1.0, 0.0]]),
        "turns": np.array([0.0, np.pi / 2]),
        "stores": False,
        "inlets": 1,
    }
    return Junction(**usual | changes)


@given(share=st.floats(SHARES[0], SHARES[-1]))
def test_the_shares_around_one_have_it_as_their_mean(share: float) -> None:
    found = weigh_shares(share, 0.0)
    assert sum(weight for _, weight in found) == pytest.approx(1)
    assert sum(step * weight for step, weight in found) == pytest.approx(share, abs=1e-5)


@given(size=st.floats(0.01, 0.95), part=st.floats(0.0, 0.999))
def test_nothing_enters_an_outlet_below_the_smallest_share_of_streamtubes(size: float, part: float) -> None:
    share = part * smallest_share(size)
    assert weigh_shares(share, size) == [(0.0, 1.0)]
    assert weigh_shares(1 - share, size) == [(1.0, 1.0)]


@given(ratio=st.floats(0.35, 1.0), size=st.floats(0.01, 0.9), angle=st.sampled_from(sorted(RATIOS)))
def test_a_body_that_fits_into_a_branch_fits_into_the_one_that_stands_for_it(
    ratio: float, size: float, angle: float
) -> None:
    assert size > ratio or size < match_ratio(ratio, size, RATIOS[angle])


@pytest.mark.parametrize("angle", sorted(RATIOS))
def test_the_flow_in_every_tee_that_stands_for_others_comes_with_driftform(angle: float) -> None:
    from driftform.water.tee_store import PACKAGED, file_name
    from driftform.water.tee_wall import Junction

    for ratio in RATIOS[angle]:
        shape = Junction(ratio, np.deg2rad(min(angle, 180 - angle)), round(0.2 * ratio, 9))
        assert (PACKAGED / file_name(shape)).is_file()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"inlets": 2}, "join"),
        ({"bore": 0.0}, "no bore upstream"),
        ({"bores": np.array([0.3, 0.32])}, "wide branch"),
        ({"bores": np.array([0.3, 0.05])}, "narrow branch"),
        ({"turns": np.array([0.0, np.deg2rad(150)])}, "steep branch"),
        ({"directions": np.array([[1.0, 0.0], [-1.0, 0.0]])}, "no straight run"),
        (
            {
                "bores": np.full(3, 0.3),
                "directions": np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0]]),
                "turns": np.array([0.0, 1.5, 1.5]),
            },
            "cross",
        ),
    ],
)
def test_streamtubes_divide_what_is_no_tee_of_the_core_and_the_reason_is_named(
    changes: dict[str, Any], reason: str
) -> None:
    assert find_branches(make_junction()) == ([1], "")
    assert find_branches(make_junction(**changes)) == ([], reason)


def test_junctions_are_counted_once_for_all_members_and_flights_come_first() -> None:
    one, two = {1: TEE, 2: "join", 3: "join"}, {1: "join", 2: TEE}
    assert count_passings([one, two]) == {
        "flown": 2,
        "streamtubes": {"join": 1},
    }


def test_the_mirror_image_of_a_band_is_that_of_its_points() -> None:
    points = spread_points(1.0)
    assert np.array_equal(MIRROR[find_band(points, 1.0)], find_band(points * [-1, 1], 1.0))


def test_what_is_not_carried_on_from_a_tee_is_held_there() -> None:
    onward = np.zeros((BANDS, 2, BANDS))
    onward[:, RUN, 5], onward[:, BRANCH, 1] = 0.5, 0.3
    table = divide_bodies(open_traveller("sphere:60mm"), make_junction(), None, 0.02, onward, TEE)
    assert table.passing == TEE
    assert table.obstacle == "held in a tee, where the flow divides"
    assert table.choice == pytest.approx(np.tile([0.5, 0.3], (BANDS, 1)))
    assert table.arrival[0].argmax(axis=1).tolist() == [5, 1]
    assert table.arrival.sum(axis=2) == pytest.approx(1)


def test_a_neutral_sphere_enters_a_branch_alike_on_every_side() -> None:
    """A sphere beside the branch enters it, and keeps its band as seen in the branch; one on the opposite side stays in the run."""
    sphere, entered = open_traveller("sphere:20mm"), []
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


def test_a_wide_sphere_sees_less_of_a_slow_branch_than_water(
    fork_file: Any, call: Callable[..., Any], tmp_path: Any
) -> None:
    network = open_network(fork_file, tmp_path)
    branch = network.find_node("branch")
    narrow, wide = (route(network, name, "source", cache=tmp_path) for name in ("sphere:20mm", "sphere:80mm"))
    fork = network.find_node("fork")
    assert narrow.passings == {fork: "narrow body"}
    assert wide.passings == {fork: TEE}
    assert wide.probability[branch] < narrow.probability[branch] - 0.02
    assert sum(end.probability for end in wide.ends) == pytest.approx(1)
    result = call("route", fork_file, "sphere:80mm", "--release", "source", "--cache", tmp_path)
    assert "flown through 1 junctions; streamtubes divide bodies at 0" in result.stdout
