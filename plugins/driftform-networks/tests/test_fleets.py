"""Fleets: the choice against all choices, and the bounds against those of a network that is known."""

from itertools import combinations_with_replacement
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.design.opening import open_agent
from driftform_networks.hydraulics.network import take_snapshot
from driftform_networks.passages.passage import find_reachable
from driftform_networks.planning.candidates import spread_rows
from driftform_networks.planning.choosing import bound_steering, choose_fleet
from driftform_networks.planning.following import trace

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


@pytest.mark.parametrize(
    ("size", "divided", "steered"), [(1, 0.319, 0.457), (5, 0.418, 0.768), (10, 0.479, 0.912), (23, 0.583, 1.0)]
)
def test_the_headroom_of_net3_is_the_known_one(size, divided, steered, epanet):
    """Drifters from River that divide like the water, and that are steered perfectly, at hour 0."""
    network = epanet.read_library("Net3")
    snapshot, river = take_snapshot(network), network.find_node("River")
    reachable = find_reachable(network, river, [0])
    length = np.where(reachable, network.length, 0.0)
    _, coverage, _ = choose_fleet(trace(network, "River", steady=True, walks=0).seen[None], length, size)
    assert coverage[-1] == pytest.approx(divided, abs=6e-4)
    assert bound_steering([[snapshot]], [river], reachable, size) == pytest.approx(steered, abs=6e-4)


@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.integers(1, 4))
@settings(max_examples=60, deadline=None)
def test_the_greedy_choice_and_its_bound_enclose_the_best_choice(seed, bodies, size):
    rng = np.random.default_rng(seed)
    seen = rng.random((bodies, 6)) * (rng.random((bodies, 6)) < 0.6)
    seen[0, 0] = 0.5
    length = rng.random(6) + 0.1
    chosen, coverage, bound = choose_fleet(seen, length, size)
    best = max(
        length @ (1 - np.prod(1 - seen[list(rows)], axis=0)) / length.sum()
        for rows in combinations_with_replacement(range(bodies), size)
    )
    assert (1 - 1 / np.e) * best - 1e-12 <= coverage[-1] <= best + 1e-12 <= bound[-1] + 1e-9
    assert (np.diff(coverage) >= -1e-12).all()
    assert coverage[-1] == pytest.approx(length @ (1 - np.prod(1 - seen[chosen], axis=0)) / length.sum())


def test_rows_are_chosen_far_from_each_other():
    points = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 0.0], [0.0, 9.0], [9.9, 0.1]])
    assert spread_rows(points, 3).tolist() == [1, 3, 0]
    assert len(spread_rows(points, 9)) == 4


def test_a_fleet_has_the_keys_of_the_contract_and_its_files(done, fork_file):
    words = ["fleet", fork_file, "--release", "source", "--size", 4, "--agent", WORD]
    words += ["--buoyancy", 0, "--buoyancy-error", 0]
    files = ["--map", "map.svg", "--tables", "tables", "--report", "fleet.html", "--agents", "agents"]
    document = done(*words, *files, "--json")
    assert len(document["members"]) == 4
    assert {"agent", "release", "hour", "probability", "gain", "stuck"} == set(document["members"][0])
    # The main is seen by all, and the branch by one third of each.
    assert document["split_by_flow"] == pytest.approx((1 + (1 - (1 / 3) ** 4) + (1 - (2 / 3) ** 4)) / 3)
    assert document["bound"] == pytest.approx(1)
    assert document["coverage"] == pytest.approx(sum(member["gain"] for member in document["members"]))
    assert document["coverage"] <= document["choice_bound"] <= 1
    assert document["coverage"] <= document["bound"]
    gap = (document["coverage"] - document["split_by_flow"]) / (document["bound"] - document["split_by_flow"])
    assert document["gap_closed"] == pytest.approx(gap)
    assert all(np.diff(document["curve"][name]).min() >= 0 for name in ("coverage", "split_by_flow", "bound"))
    assert all(Path(file).is_file() for file in document["files"])
    lines = ET.parse("map.svg").getroot().findall(".//{*}path[@class='link']")
    assert len(lines) == 3
    page = Path("fleet.html").read_text()
    assert page.count("<svg") == 1
    assert "http" not in page.replace("http://www.w3.org", "")
    for path in Path("agents").iterdir():
        design = open_agent(str(path))
        assert design.net_buoyancy == pytest.approx(0, abs=1e-9)
