"""Point tracers against EPANET's own quality engine, and against themselves when they are followed one by one."""

from time import process_time
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.hydraulics.network import STILL, Network, take_snapshot
from driftform_networks.passages.passage import follow
from driftform_networks.passages.routing import route_tracers
from driftform_networks.passages.walkers import Walks, walk
from driftform_networks.planning.following import trace


def arriving_flow(snapshot):
    return np.bincount(snapshot.head, snapshot.flow, len(snapshot.network.nodes))


def is_junction(network):
    return np.array([kind == "junction" for kind in network.node_kinds])


@pytest.mark.parametrize(
    ("name", "release", "hours"), [("Net3", "River", 200), ("ky4", "R-1", 400), ("ky10", "R-1", 400)]
)
def test_visits_are_the_trace_of_epanet(name, release, hours, tmp_path, epanet):
    """p = TRACE Q_j / Q_s: the flux of marked water through a node, relative to that of the release."""
    path = epanet.freeze(name, tmp_path)
    network = open_network(path)
    snapshot = take_snapshot(network)
    passage = follow([route_tracers(snapshot)], network.find_node(release))
    shares = epanet.simulate_quality(path, f"Trace {release}", hours, 300)
    share = np.array([shares[node] for node in network.nodes])
    expected = share * arriving_flow(snapshot) / snapshot.departure[network.find_node(release)]
    # Where water is too old, EPANET's simulation has not yet become stationary.
    settled = is_junction(network) & ~(passage.age > hours * 3600 / 5)
    assert settled.sum() > 0.7 * len(network.nodes)
    assert np.abs(100 * passage.visits - expected)[settled].max() < 1e-3


def test_mean_ages_are_those_of_epanet(tmp_path, epanet):
    """The age of water is the mean of the ages of tracers of all its sources, weighted by their flux."""
    path = epanet.freeze("Net3", tmp_path)
    network = open_network(path)
    snapshot = take_snapshot(network)
    flux, sum_of_ages = np.zeros(len(network.nodes)), np.zeros(len(network.nodes))
    for source in np.flatnonzero(network.hydraulics.outflow[0] < -STILL):
        passage = follow([route_tracers(snapshot)], int(source))
        reached = passage.visits > 0
        part = np.where(reached, passage.visits, 0) * snapshot.departure[source]
        flux += part
        sum_of_ages += part * np.where(reached, passage.age, 0)
    # The slowest link takes 125 h.
    ages = epanet.simulate_quality(path, "Age", 400, 300, 1e-4)
    with np.errstate(invalid="ignore"):
        mean = sum_of_ages / flux
    # Of older water, EPANET's simulation has not seen all.
    known = is_junction(network) & (mean < 12 * 3600)
    assert known.sum() >= 80
    mean = mean[known]
    expected = 3600 * np.array([ages[node] for node in network.nodes])[known]
    assert np.abs(mean / expected - 1).max() < 1e-3


@pytest.mark.parametrize(("name", "release"), [("Net3", "River"), ("ky4", "R-1"), ("ky10", "R-2")])
def test_ten_thousand_walks_agree_with_the_chain_in_a_second(name, release, epanet):
    snapshot = take_snapshot(epanet.read_library(name))
    node, routing = snapshot.network.find_node(release), route_tracers(snapshot)
    passage = follow([routing], node)
    began = process_time()
    walks = walk([routing], [0, np.inf], node, np.zeros(10_000), np.random.default_rng(1))
    assert process_time() - began < 1
    rows = walks.first_arrivals()
    arrived, time = walks.node[rows], walks.ages[rows]
    count = np.bincount(arrived, minlength=len(snapshot.network.nodes))
    p = np.delete(passage.probability, node)
    deviation = np.delete(count / 10_000, node) - p
    # Four standard deviations, with more room for rare nodes, whose counts are not normal.
    assert (np.abs(deviation) <= 4 * np.sqrt(p * (1 - p) / 10_000) + 2e-4).all()
    often = count > 1000
    age = np.bincount(arrived, time, len(count))[often] / count[often]
    assert age == pytest.approx(passage.age[often], rel=0.05)


def test_water_that_turns_back_is_followed_as_epanet_does(tmp_path, epanet):
    """A day of Net3 with tanks as reservoirs: marked water that arrives, over all marked water."""
    sections, network = epanet.read_sections("Net3"), epanet.read_library("Net3")
    head = dict(zip(network.nodes, network.hydraulics.head[0] / 0.3048, strict=True))
    controls = [" ".join(row) for row in epanet.list_rows(sections["CONTROLS"]) if "IF" not in row]
    sections |= {
        "RESERVOIRS": sections["RESERVOIRS"]
        + "".join(f"{row[0]} {head[row[0]]}\n" for row in epanet.list_rows(sections["TANKS"])),
        "TANKS": "",
        "CONTROLS": "\n".join(controls),
        "OPTIONS": sections["OPTIONS"].replace("Trace Lake", "Trace River").replace("0.01", "1e-6"),
        "TIMES": sections["TIMES"].replace("168:00", "24:00").replace("0:05", "0:01"),
    }
    path = epanet.write_sections(tmp_path / "day.inp", sections)
    network = open_network(path)
    h, river = network.hydraulics, network.find_node("River")
    assert ((h.flow > STILL).any(axis=0) & (h.flow < -STILL).any(axis=0)).sum() > 40
    names, times, values = epanet.follow_quality(path)
    shares = values[:, [names.index(node) for node in network.nodes]] / 100
    arriving = np.array([
        np.bincount(network.end, np.maximum(flow, 0), len(network.nodes))
        + np.bincount(network.start, np.maximum(-flow, 0), len(network.nodes))
        for flow in h.flow
    ])  # fmt: skip
    row = np.searchsorted(h.times, times + 1e-6, side="right") - 1
    duration = np.diff(np.append(times, h.end))[:, None]
    middle = (shares + np.vstack([shares[1:], shares[-1:]])) / 2
    steps = np.diff(np.append(h.times, h.end))
    released = -h.outflow[:, river] * steps
    expected = (middle * arriving[row] * duration).sum(axis=0) / released.sum()
    rng, count = np.random.default_rng(2), 20_000
    step = rng.choice(len(steps), count, p=released / released.sum())
    routings = [route_tracers(take_snapshot(network, time / 3600)) for time in h.times]
    began = h.times[step] + rng.random(count) * steps[step]
    walks = walk(routings, [*h.times, h.end], river, began, rng)
    visits = np.bincount(walks.node[walks.node >= 0], minlength=len(network.nodes)) / count
    deviation = np.abs(visits - expected)[is_junction(network)]
    assert (deviation <= 4 * np.sqrt(np.maximum(expected * (1 - expected), 1e-4) / count)[is_junction(network)]).all()


def test_ends_and_coverage_add_up(epanet):
    passage = trace(epanet.read_library("Net3"), "River", steady=True)
    assert sum(end.probability for end in passage.ends) == pytest.approx(1, abs=1e-6)
    assert passage.coverage == pytest.approx(0.3188, abs=5e-5)
    changing = trace(epanet.read_library("Net3"), "River", walks=4000)
    assert sum(end.probability for end in changing.ends) == pytest.approx(1)
    assert 0 < changing.coverage < passage.coverage


def test_the_same_seed_gives_the_same_walks(epanet):
    one, two, other = (trace(epanet.read_library("Net3"), "River", walks=500, seed=s) for s in (3, 3, 4))
    assert one.as_document() == two.as_document() != other.as_document()


def test_retained_tracers_stay_where_water_flows_on(epanet):
    snapshot = take_snapshot(epanet.read_library("Net3"))
    flows_on = np.array([bool(len(table.choice[0])) for table in route_tracers(snapshot).tables])
    inside = flows_on & ~np.isin(snapshot.head, np.flatnonzero(snapshot.network.stores))
    staying, leaving = (
        np.array([table.choice.sum() for table in route_tracers(snapshot, retained=kept).tables])[inside]
        for kept in (True, False)
    )
    assert staying == pytest.approx(np.ones(len(staying)))
    assert leaving.max() < 1 + 1e-9 and leaving.min() < 0.9


def test_a_link_that_a_walk_passes_twice_is_seen_once():
    network = SimpleNamespace(links=("A", "B"), worth=np.array([10.0, 4.0]))
    moves = {"walk": [0, 0, 0, 1], "link": [0, 1, 0, 1], "node": [1, 2, 1, 2]}
    walks = Walks(
        cast(Network, network),
        0,
        np.zeros(2),
        **{name: np.array(column) for name, column in moves.items()},
        low=np.zeros(4),
        high=np.ones(4),
        reached=np.arange(1.0, 5.0),
        ends=np.zeros(2, int),
        place=np.array([1, 2]),
    )
    assert walks.measure_records().tolist() == [10.0, 14.0, 14.0, 4.0]


def test_times_count_from_each_release_and_all_flows_of_a_walk_have_one_factor(fork_file, tmp_path):
    network = open_network(fork_file, tmp_path)
    fork, source = network.find_node("fork"), network.find_node("source")
    routings, began = [route_tracers(take_snapshot(network))], np.linspace(0, 9000, 4000)
    walks = walk(routings, [0, np.inf], source, began, np.random.default_rng(1), demand_error=0.3)
    rows = walks.first_arrivals()
    place, time = walks.node[rows], walks.ages[rows]
    # 200 m of 300 mm at 30 l/s.
    log = np.log(time[place == fork] / (200 * np.pi * 0.3**2 / 4 / 0.03))
    assert len(log) == 4000
    assert [log.mean(), log.std()] == pytest.approx([0, 0.3], abs=0.015)
    assert abs(np.corrcoef(log, began)[0, 1]) < 0.06


def test_a_demand_where_bodies_are_released_takes_its_share_of_them(fork_file, tmp_path):
    path = tmp_path / "drawn.inp"
    path.write_text(fork_file.read_text().replace(" fork 10 0", " fork 10 15"))
    network = open_network(path, tmp_path)
    fork = network.find_node("fork")
    routings = [route_tracers(take_snapshot(network))]
    walks = walk(routings, [0, np.inf], fork, np.zeros(4000), np.random.default_rng(1))
    # 15 of 45 l/s leave there.
    assert (walks.place == fork).mean() == pytest.approx(1 / 3, abs=0.03)
