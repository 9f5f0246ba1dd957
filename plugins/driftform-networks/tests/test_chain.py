"""Tables of networks that can be computed by hand: what the chain solves, and what walks draw from the same tables."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import lognorm

from driftform_networks.flights.bodies import open_traveller
from driftform_networks.hydraulics.network import Hydraulics, Network, take_snapshot
from driftform_networks.passages.passage import QUANTILES, find_loops, follow
from driftform_networks.passages.routing import Routing, RoutingTable, TransferTable, route_tracers
from driftform_networks.passages.walkers import count_ends, summarise_walks, walk
from driftform_networks.planning.following import Case, How, route, trace

LENGTH, AREA = 100.0, 0.01
"""Of every pipe, m and m2."""


def make_network(flows, kinds=None):
    """Pipes such as ``"ab"`` from a to b, with their flows, m3/s, at each hour; demands are what the flows leave."""
    nodes = tuple(dict.fromkeys("".join(flows)))
    flow = np.array([np.atleast_1d(values) for values in flows.values()], float).T
    start, end = (np.array([nodes.index(pipe[side]) for pipe in flows]) for side in (0, 1))
    outflow = np.zeros((len(flow), len(nodes)))
    for step, row in enumerate(flow):
        np.add.at(outflow[step], end, row)
        np.subtract.at(outflow[step], start, row)
    times = 3600.0 * np.arange(len(flow))
    hydraulics = Hydraulics(times, 3600.0 * len(flow), flow, outflow, np.full_like(outflow, 50.0))
    return Network(
        name="by hand",
        digest="",
        nodes=nodes,
        node_kinds=tuple((kinds or {}).get(node, "junction") for node in nodes),
        elevation=np.zeros(len(nodes)),
        places=np.zeros((len(nodes), 2)),
        links=tuple(flows),
        link_kinds=("pipe",) * len(flows),
        start=start,
        end=end,
        length=np.full(len(flows), LENGTH),
        diameter=np.full(len(flows), np.sqrt(4 / np.pi * AREA)),
        vertices=(np.zeros((0, 2)),) * len(flows),
        hydraulics=hydraulics,
    )


def travel_time(flow):
    return LENGTH * AREA / flow


def find_ends(passage):
    return {(end.kind, end.place): end.probability for end in passage.ends}


def test_tracers_divide_at_two_forks_by_the_product_of_the_shares():
    """Of 12 litres/s from a, 8 go on at b, of which 2 leave with its demand, and 5 at c."""
    network = make_network({"ab": 0.012, "bc": 0.008, "bd": 0.002, "ce": 0.005})
    passage = trace(network, "a", walks=0)
    assert passage.probability == pytest.approx([1, 1, 8 / 12, 2 / 12, 5 / 12])
    first, second, third = (travel_time(flow) for flow in (0.012, 0.008, 0.005))
    assert passage.age[[1, 2, 4]] == pytest.approx([first, first + second, first + second + third])
    ends = {("demand", "b"): 2, ("demand", "c"): 3, ("demand", "d"): 2, ("demand", "e"): 5}
    assert find_ends(passage) == pytest.approx({end: litres / 12 for end, litres in ends.items()})
    assert passage.coverage == pytest.approx((1 + 8 / 12 + 2 / 12 + 5 / 12) / 4)


def test_the_age_where_two_ways_meet_is_their_mean_by_flow():
    network = make_network({"ab": 0.003, "ac": 0.001, "bd": 0.003, "cd": 0.001})
    passage = trace(network, "a", walks=0)
    ages = [2 * travel_time(0.003), 2 * travel_time(0.001)]
    assert passage.probability[network.find_node("d")] == pytest.approx(1)
    assert passage.age[network.find_node("d")] == pytest.approx(0.75 * ages[0] + 0.25 * ages[1])


def make_loop():
    """Water that a pump sends round from b over c back to b: of 4 litres/s through c, 3 return."""
    return make_network({"ab": 0.001, "bc": 0.004, "cb": 0.003, "cd": 0.001})


def test_visits_in_a_loop_are_a_geometric_series():
    network = make_loop()
    passage = trace(network, "a", walks=0)
    assert [network.nodes[node] for node in find_loops(take_snapshot(network))] == ["b", "c"]
    # Each time at c, three quarters return: 1 / (1 - 3/4) arrivals there, and as many at b.
    assert passage.visits == pytest.approx([1, 4, 4, 1], rel=1e-6)
    assert passage.probability == pytest.approx(1, rel=1e-6)
    there, back = travel_time(0.004), travel_time(0.003)
    mean = travel_time(0.001) + there + 3 * (there + back)
    assert passage.age[network.find_node("c")] == pytest.approx(mean, rel=1e-6)
    assert passage.age[network.find_node("d")] == pytest.approx(mean + travel_time(0.001), rel=1e-6)


def test_a_branch_of_a_loop_is_entered_with_the_probability_of_all_rounds():
    """At each pass of c a sixth leaves to e, a sixth to d, and two thirds return."""
    network = make_network({"ab": 0.002, "bc": 0.006, "cb": 0.004, "cd": 0.001, "ce": 0.001})
    passage = trace(network, "a", walks=0)
    seen = dict(zip(network.links, passage.seen, strict=True))
    # It returns at least once with 2/3, and leaves to either side with 1/2.
    assert [seen["bc"], seen["cb"], seen["cd"], seen["ce"]] == pytest.approx([1, 2 / 3, 1 / 2, 1 / 2], rel=1e-6)


def test_what_cannot_leave_a_loop_circles():
    network = make_network({"ab": 0.001, "bc": 0.004, "cb": 0.003, "cd": 0.001})
    routing = route_tracers(take_snapshot(network))
    back = routing.snapshot.outlets[network.find_node("c")]
    tables = list(routing.tables)
    closed = (routing.snapshot.links[back] == network.links.index("cb")).astype(float)
    tables[network.links.index("bc")] = RoutingTable(closed[None], np.ones((1, 2, 1)), np.zeros(1))
    passage = follow([Routing(routing.snapshot, routing.transfers, tables, np.ones(1))], 0)
    assert find_ends(passage) == pytest.approx({("circling", ""): 1}, abs=1e-6)


def test_a_body_that_each_pipe_holds_with_one_tenth_arrives_with_powers_of_nine_tenths():
    network = make_network({"ab": 0.001, "bc": 0.001, "cd": 0.001})
    routing = route_tracers(take_snapshot(network))
    held = TransferTable(np.array([[0.9]]), np.array([2.0]), "lies on the wall")
    passage = follow([Routing(routing.snapshot, [held] * 3, routing.tables, np.ones(1))], 0)
    assert passage.probability == pytest.approx([1, 0.9, 0.81, 0.729])
    assert passage.seen == pytest.approx([0.9, 0.81, 0.729])
    # It is half as fast as the water.
    assert passage.age == pytest.approx(2 * travel_time(0.001) * np.arange(4))
    ends = {("stuck", "ab"): 0.1, ("stuck", "bc"): 0.09, ("stuck", "cd"): 0.081, ("demand", "d"): 0.729}
    assert find_ends(passage) == pytest.approx(ends)
    assert {end.reason for end in passage.stuck} == {"lies on the wall"}


def make_banded(network):
    """Two bands: a pipe moves 1/5 from the first to the second; the first goes to c, half of the second to d, and the rest is held."""
    snapshot = take_snapshot(network)
    transfer = TransferTable(np.array([[0.8, 0.2], [0.0, 1.0]]), np.array([1.0, 3.0]))
    outlets = [network.links[snapshot.links[link]] for link in snapshot.outlets[network.find_node("b")]]
    assert outlets == ["bc", "bd"]
    choice = np.array([[1.0, 0.0], [0.0, 0.5]])
    arrival = np.broadcast_to(np.array([[0.0, 1.0]]), (2, 2, 2))
    fork = RoutingTable(choice, arrival, np.zeros(2), "held at the fork")
    end = RoutingTable(np.zeros((2, 0)), np.zeros((2, 0, 2)), np.ones(2))
    return Routing(snapshot, [transfer] * 3, [fork, end, end], np.array([0.75, 0.25]))


def test_bands_move_as_the_product_of_their_tables():
    network = make_network({"ab": 0.002, "bc": 0.001, "bd": 0.001})
    passage = follow([make_banded(network)], 0)
    # 3/4 enter in the first band, and 4/5 of these are still in it at the fork.
    first = 0.75 * 0.8
    assert passage.probability == pytest.approx([1, 1, first, (1 - first) / 2])
    assert find_ends(passage)["stuck", "b"] == pytest.approx((1 - first) / 2)
    # Time by the band of entry; all enter the next pipes in the second band.
    start = travel_time(0.002)
    assert passage.age[1] == pytest.approx((0.75 * 1 + 0.25 * 3) * start)
    assert passage.age[2] == pytest.approx(1 * start + 3 * travel_time(0.001))
    later = (0.75 * 0.2 * 1 + 0.25 * 3) / (1 - first)
    assert passage.age[3] == pytest.approx(later * start + 3 * travel_time(0.001))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_all_water_of_the_only_source_is_marked(seed):
    """In any network without loops, the arrivals at a node are its water over that of the source, and ends add up."""
    rng = np.random.default_rng(seed)
    names, through, flows = "abcdefgh", {"a": 1.0}, {}
    for number, node in enumerate(names[:-1]):
        after = rng.choice(list(names[number + 1 :]), min(3, len(names) - number - 1), replace=False)
        keeps = rng.random() * 0.5
        for other, share in zip(after, rng.dirichlet(np.ones(len(after))), strict=True):
            flow = through.get(node, 0.0) * (1 - keeps) * share
            if flow > 1e-3:
                flows[node + other] = flow
                through[other] = through.get(other, 0.0) + flow
    network = make_network(flows)
    source = sum(flow for pipe, flow in flows.items() if pipe[0] == "a")
    passage = trace(network, "a", walks=0)
    assert passage.visits[1:] == pytest.approx([through[node] / source for node in network.nodes[1:]])
    assert passage.seen == pytest.approx(np.array(list(flows.values())) / source)
    assert sum(end.probability for end in passage.ends) == pytest.approx(1)
    drawn = trace(network, "a", walks=200)
    assert sum(end.probability for end in drawn.ends) == pytest.approx(1)


def test_bodies_that_go_round_in_a_loop_for_ever_are_counted_as_circling():
    routing = route_tracers(take_snapshot(make_network({"ab": 0.001, "bc": 0.003, "cb": 0.002})), retained=True)
    walks = walk([routing], [0, np.inf], 0, np.zeros(3), np.random.default_rng(1))
    assert [(end.kind, end.probability) for end in count_ends(walks, [routing])] == [("circling", pytest.approx(1))]


@pytest.mark.parametrize("make", [make_loop, lambda: make_network({"ab": 0.002, "bc": 0.001, "bd": 0.001})])
def test_walks_agree_with_the_chain_that_they_are_drawn_from(make):
    network = make()  # type: ignore[operator]
    routing = make_banded(network) if len(network.links) == 3 else route_tracers(take_snapshot(network))
    exact, count = follow([routing], 0), 40_000
    rng = np.random.default_rng(5)
    drawn = summarise_walks(walk([routing], [0, np.inf], 0, np.zeros(count), rng), [routing])
    error = 4 * 0.5 / np.sqrt(count)
    assert drawn.probability == pytest.approx(exact.probability, abs=error)
    assert drawn.seen == pytest.approx(exact.seen, abs=error)
    assert find_ends(drawn) == pytest.approx(find_ends(exact), abs=error)
    assert drawn.visits == pytest.approx(exact.visits, rel=0.05)


def test_a_body_comes_back_where_the_flow_reverses_and_sees_the_part_that_it_went():
    """An hour of 0.1 litres/s into a pipe of 1000 litres, and an hour of 0.2 back: it turns after 36 % of the pipe."""
    network = make_network({"ab": [1e-4, -2e-4], "ca": [1e-4, -2e-4]}, {"b": "tank", "c": "reservoir"})
    passage = trace(network, "a", walks=50)
    assert dict(zip(network.links, passage.seen, strict=True)) == pytest.approx({"ab": 0.36, "ca": 0.36})
    assert find_ends(passage) == {("under way", ""): 1.0}
    # It is back at the release after half an hour, and never arrives elsewhere.
    assert passage.visits == pytest.approx([2, 0, 0])
    assert passage.probability == pytest.approx([1, 0, 0])


def test_a_body_is_as_fast_as_the_flow_of_each_hour():
    """An hour of 0.1 litres/s takes it through 360 of 1000 litres, and 0.2 litres/s through the other 640 in 3200 s."""
    passage = trace(make_network({"ab": [1e-4, 2e-4]}), "a", walks=50)
    assert passage.probability == pytest.approx([1, 1])
    assert passage.age[1] == pytest.approx(3600 + 3200)
    steady = trace(make_network({"ab": [1e-4, 2e-4]}), "a", steady=True)
    assert steady.age[1] == pytest.approx(10_000)


def test_a_body_waits_in_an_hour_without_any_flow():
    passage = trace(make_network({"ab": [1e-4, 0.0, 2e-4]}), "a", walks=50)
    assert passage.age[1] == pytest.approx(3600 + 3600 + 3200)


def test_a_wide_body_waits_at_a_dead_end_until_water_leads_on():
    neutral = replace(open_traveller("sphere:60mm"), error=0.0)
    passage = route(make_network({"ab": [1e-3, 1e-3], "bc": [0.0, 1e-3]}), neutral, "a", walks=50)
    assert passage.quantiles[2].min() > 3600
    assert find_ends(passage) == {("stuck", "c"): 1.0}


def test_flows_that_do_not_change_are_the_same_with_and_without_steps():
    flows = {"ab": [0.012] * 3, "bc": [0.008] * 3, "bd": [0.004] * 3}
    network = make_network(flows)
    steady = trace(network, "a", steady=True, walks=0)
    drawn = trace(network, "a", walks=20_000)
    assert drawn.probability == pytest.approx(steady.probability, abs=0.015)
    assert drawn.age == pytest.approx(steady.age)
    assert all(low == high for low, high in pairwise(drawn.quantiles[1]))
    assert drawn.quantiles[:, 1] == pytest.approx(steady.age)


@pytest.mark.parametrize("more", [{}, {"within": 24.0}])
def test_bodies_that_are_drawn_keep_their_weight_and_their_error_of_flows_all_the_way(more):
    """Half travel at the pace of the water, half at 0.7 of it, through five pipes: a mixture of two log-normal distributions."""
    network = make_network(dict.fromkeys(("ab", "bc", "cd", "de", "ef"), 0.001))
    how = How(walks=20_000, demand_error=0.1, **more)
    case = Case(network, "a", 0.0, [take_snapshot(network)], how)

    def route_at(pace, snapshot):
        run = TransferTable(np.ones((1, 1)), np.full(1, 1 / pace))
        return replace(route_tracers(snapshot), transfers=[run] * 5)

    found, water = case.follow(*(partial(route_at, pace) for pace in (1.0, 0.7))), 5 * LENGTH * AREA / 1e-3
    shares = np.mean([lognorm.cdf(found.quantiles[-1], 0.1, scale=water / pace) for pace in (1.0, 0.7)], axis=0)
    assert shares == pytest.approx(QUANTILES, abs=4 * np.sqrt(0.25 / 20_000))
    error = np.exp(0.1**2 / 2) if more else 1.0
    assert found.age[-1] == pytest.approx(error * water * (1 + 1 / 0.7) / 2, rel=0.01)
    assert found.probability == pytest.approx(1) and found.seen == pytest.approx(1)
