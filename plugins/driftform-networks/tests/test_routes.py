"""Routes of bodies: the limit of point tracers, what fits where, and flights that are kept."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.agent import mass_properties
from driftform.design.design import Design
from driftform.design.opening import open_agent
from driftform.errors import InputError
from driftform.water.disturbances import Specimen, disturb_fluid, draw_conditions
from driftform.water.prints import disturb_body
from driftform_networks.flights.bodies import buoyancy_error, open_traveller, trim_design
from driftform_networks.flights.bore import divide_bore, spread_points
from driftform_networks.flights.limits import word_weight
from driftform_networks.flights.travelling import Travel
from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.hydraulics.network import take_snapshot
from driftform_networks.passages.routing import TEE
from driftform_networks.planning.fleets import plan_fleet
from driftform_networks.planning.following import How, route, trace
from driftform_networks.planning.plans import plan_inspection

PUMPED = Travel(clearance={"pump": 1.0})
"""River feeds a pump of Net3."""

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


def test_a_well_mixed_small_sphere_goes_where_tracers_go(epanet, tmp_path):
    network = epanet.read_library("Net3")
    sphere, water = replace(open_traveller("sphere:5mm"), error=0.0), trace(network, "River", steady=True, walks=0)
    began = process_time()
    passage = route(network, sphere, "River", travel=PUMPED, cache=tmp_path, steady=True, walks=0)
    assert process_time() - began < 0.5
    assert np.abs(passage.probability - water.probability).max() < 0.005
    assert passage.coverage == pytest.approx(water.coverage, abs=0.005)


def test_a_route_has_the_keys_of_the_contract(done):
    words = "route Net3 sphere:21mm --release River --clearance pump=1 --service-bore 0.02 --steady 0 --walks 0 --buoyancy-error 0 --json"
    document = done(*words.split())
    assert document["nodes"]["River"] == {"probability": 1.0, "age": 0.0}
    assert all(0 < node["probability"] <= 1 and node["age"] >= 0 for node in document["nodes"].values())
    assert 0 < document["coverage"] < 1
    assert sum(end["probability"] for end in document["ends"]) == pytest.approx(1, abs=1e-6)
    assert {"kind", "place", "probability", "reason"} == set(document["stuck"][0])
    # It does not leave with the demand, but in tanks.
    assert {end["kind"] for end in document["ends"]} == {"stuck", "tank"}
    assert set(document["branches"]) == {"top", "side", "bottom"}
    assert document["branches"]["side"]["largest_change"] == 0


def test_a_body_is_warned_of_in_the_pipes_that_it_fills_and_is_flown_through(done, fork_file):
    narrow, found = fork_file.read_text().replace("side fork branch 200 300", "side fork branch 200 150"), {}
    Path("narrow.inp").write_text(narrow)
    for agent in ("sphere:80mm", "sphere:40mm"):
        words = ("route", "narrow.inp", agent, "--release", "source", "--buoyancy", -0.01, "--branch", "bottom")
        found[agent] = done(*words, "--buoyancy-error", 0, "--walks", 0, "--json")["warnings"]
    # It goes through 200 m of 300 mm, where it is in range, and into a branch of 200 m, where 80 of 150 mm are too much.
    (line,) = found["sphere:80mm"]
    assert line.startswith("warning: sphere-80mm-heavy-10mN in 150 mm at ") and "b = 0.5333; it holds" in line
    assert line.endswith("so it is in 50 % of what it sees") and found["sphere:40mm"] == []


@pytest.mark.parametrize(("more", "kind"), [([], "demand"), (["--service-bore", 0.02], "stuck")])
def test_a_demand_takes_bodies_that_fit_the_pipe_which_it_needs(more, kind, done, fork_file):
    """20 and 10 litres/s at 1 m/s are pipes of 160 and 113 mm."""
    words = ["route", fork_file, "sphere:25mm", "--release", "source", "--buoyancy-error", 0, *more]
    assert {end["kind"] for end in done(*words, "--json")["ends"]} == {kind}
    reason = "drawn off with the demand" if kind == "demand" else "at a dead end"
    assert f"bodies end 100.0 % {reason}\n" in done(*words)


@given(
    shares=st.lists(st.floats(0.05, 1), min_size=2, max_size=4).map(lambda x: np.array(x) / sum(x)),
    clocks=st.lists(st.sampled_from([0.0, 90.0, 180.0, 270.0]), min_size=3, max_size=3),
)
@settings(max_examples=30, deadline=None)
def test_water_divides_in_the_ratio_of_the_flows(shares, clocks):
    clock = np.deg2rad(clocks[: len(shares) - 1])
    directions = np.vstack([[0.0, 0.0], np.column_stack([np.sin(clock), np.cos(clock)])])
    divided = divide_bore(spread_points(1.0), directions, shares)
    assert divided.sum(axis=1) == pytest.approx(1)
    assert divided.mean(axis=0) == pytest.approx(shares, abs=2e-3)


def test_heavy_bodies_go_into_branches_at_the_bottom_and_light_ones_at_the_top(fork_file, tmp_path_factory):
    cache = tmp_path_factory.getbasetemp() / "flights"
    network = open_network(fork_file, cache)
    entered = {}
    for buoyancy in (-0.01, 0.01):
        traveller = replace(open_traveller("sphere:60mm", buoyancy=buoyancy), error=0.0)
        found = route(network, traveller, "source", walks=0, cache=cache, compare=True)
        for side, passage in found.branches.items():
            entered[buoyancy, side] = passage.probability[network.find_node("branch")]
    assert entered[-0.01, "bottom"] > 0.95
    assert entered[-0.01, "top"] < 0.05
    assert entered[0.01, "top"] > 0.95
    assert entered[0.01, "bottom"] < 0.05


def test_of_neutral_bodies_the_lighter_half_enters_a_branch_at_the_top_and_the_heavier_stays(fork_file, tmp_path):
    """Routes by the chain and by walks, fleets and plans draw the weights alike."""
    network, body = open_network(fork_file, tmp_path), replace(open_traveller("sphere:60mm"), error=0.01)
    branch, how = network.find_node("branch"), {"travel": Travel("top"), "walks": 300, "cache": tmp_path}
    for more in ({}, {"within": 10.0}):
        found = route(network, body, "source", **how, **more)
        assert found.probability[branch] == pytest.approx(0.5, abs=0.03)
        assert sum(end.probability for end in found.ends) == pytest.approx(1)
    assert plan_fleet(network, [body], ["source"], 2, **how).seen[-1] == pytest.approx(0.75, abs=0.03)
    planned = plan_inspection(network, [body], ["source"], 2, size=1, within=10.0, **how)
    assert planned.alone == pytest.approx([1, 0.5, 0.5], abs=0.03)
    # The water mixes bodies of up to 6 mg of net weight here.
    assert word_weight(body, network, {network.find_node("fork"): TEE}, [0])[0].startswith(
        "half of the bodies weigh -1 g in the water, half 1 g; a tenth of a gram decides at 1 of 1 tees"
    )


@pytest.mark.parametrize(
    ("settings", "share"), [((), 0.03), (("robustness.bubble=0", "robustness.absorbed=0.003"), 0.1)]
)
def test_the_net_weight_of_a_body_is_as_doubtful_as_that_of_a_weighed_print(settings, share):
    """By the disturbed flights of runs, whose draws include what thermometers leave."""
    body = open_traveller(WORD, settings=settings, buoyancy=0.0)
    scenario, net = body.scenario, []
    for condition in draw_conditions(scenario.robustness, 2000, (1,)):
        made = disturb_body(replace(condition, specimen=Specimen.WEIGHED), body.agent.body, scenario.fluid)
        net.append(mass_properties(made).net_buoyancy(disturb_fluid(condition, scenario.fluid)))
    assert buoyancy_error(body.agent, scenario) == pytest.approx(np.std(net), rel=share)
    drawn = [one.net_buoyancy for one in body.drawn]
    assert (np.mean(drawn), np.std(drawn)) == pytest.approx((0, np.std(net)), rel=share, abs=1e-9)
    # As designed it weighs 27 g, and a tenth more or less changes nothing.
    assert len(open_traveller(WORD).drawn) == 1


@pytest.mark.long
@pytest.mark.parametrize("agent", ["sphere:60mm", WORD])
def test_flights_are_the_same_for_any_number_of_workers(agent, fork_file, tmp_path):
    network, body = open_network(fork_file, tmp_path), replace(open_traveller(agent, buoyancy=-0.01), error=0.0)
    How(workers=2, cache=tmp_path / "2").fly([body], [Travel()], [take_snapshot(network)])
    made = {path.name for path in (tmp_path / "2").glob("*.npz")}
    one, two = (route(network, body, "source", workers=n, cache=tmp_path / f"{n}") for n in (1, 2))
    assert one.as_document() == two.as_document()
    # The workers have made all that one process makes.
    assert made == {path.name for path in (tmp_path / "1").glob("*.npz")} != set()


@pytest.mark.long
def test_a_killed_command_loses_no_table_that_was_finished(fork_file, tmp_path):
    cache = tmp_path / "cache"
    words = ["network", "route", str(fork_file), "sphere:60mm", "--release", "source", "--buoyancy", "-0.01"]
    program = [sys.executable, "-c", "from driftform.cli import main; main()", *words]
    program += ["--buoyancy-error", "0", "--workers", "1", "--cache", str(cache), "--json"]
    process = subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    # The first file is the network.
    while len(list(cache.glob("*.npz"))) < 2 and process.poll() is None:
        time.sleep(0.05)
    assert process.poll() is None, "it was too fast to be killed"
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = {path: path.stat().st_mtime_ns for path in cache.glob("*.npz")}
    again = subprocess.run(program, capture_output=True, check=True, text=True)
    assert all(path.stat().st_mtime_ns == when for path, when in kept.items())
    assert len(list(cache.glob("*.npz"))) > len(kept)
    fresh = [*program[:-2], str(tmp_path / "fresh"), "--json"]
    assert again.stdout == subprocess.run(fresh, capture_output=True, check=True, text=True).stdout


def test_a_trimmed_agent_has_the_buoyancy_that_was_asked_for():
    for buoyancy in (0.0, 0.002):
        traveller = open_traveller(WORD, buoyancy=buoyancy)
        assert traveller.agent.mass.net_buoyancy(traveller.scenario.fluid) == pytest.approx(buoyancy, abs=1e-9)
    sphere = open_traveller("sphere:60mm", buoyancy=-0.01)
    assert sphere.agent.mass.net_buoyancy(sphere.scenario.fluid) == pytest.approx(-0.01)


def test_the_ballast_of_a_tuned_agent_trims_it_and_stays_in_its_seat():
    lead = ("builder.tuning='ballast'", "builder.ballast={material='lead', most=1.0}", "builder.pressure=0")
    plain = open_agent(f"{WORD}-addF-tiltp-2-L-moveF", "pipe-inspection", ["builder.core=glass-20mm", *lead])
    _, most = plain.pipeline.builder.find_tunings(plain.agent.morphology) or (0.0, 0.0)
    stored = replace(plain.stored, genome=replace(plain.stored.genome, tuning=0.9 * most))
    design = Design.build(stored, "tuned")
    for buoyancy in (0.0, 0.003, -0.003):
        traveller = trim_design(design, buoyancy)
        body = traveller.agent.body
        assert traveller.agent.mass.net_buoyancy(traveller.scenario.fluid) == pytest.approx(buoyancy, abs=1e-9)
        assert body.ballast.centroid == pytest.approx(design.agent.body.ballast.centroid)
        assert body.core == design.agent.body.core
        assert np.array_equal(body.outer, design.agent.body.outer)
    with pytest.raises(
        InputError, match=r"--buoyancy -9: word-\w+ can be tuned from -0.\d+ to 0.\d+ N: choose another"
    ):
        trim_design(design, -9.0)


FORK = Path(__file__).with_name("fork.inp").read_text()
LACKING = FORK.replace("300 100 0 Open\n on", "300 100 0 Closed\n on")
UNKNOWN_LINK = FORK.replace("main source", "trunk source")
TRACERS = ("tracers", "--release", "source")
UNKNOWN = FORK.replace("side fork branch", "side fork nowhere")


@pytest.mark.parametrize(
    ("text", "words", "expected"),
    [
        (UNKNOWN, ["show"], "EPANET refuses the file"),
        (UNKNOWN, ["show"], "line 11: Error 203: undefined node"),
        (LACKING, ["tracers", "--release", "source"], "EPANET finds a pressure of -"),
        (FORK, ["fleet", "--release", "source", "--clearance", "prv=2"], "a share of the bore from 0 to 1"),
        (FORK, ["fleet", "--release", "source", "--clearance", "gate=1"], "no such kind or link"),
        (FORK, ["tracers", "--release", "sauce"], "no such node; did you mean 'source'?"),
        (FORK, ["tracers", "--release", "ahead"], "no water flows from it into a pipe at hour 0"),
        (FORK, ["tracers", "--release", "source", "--at", "3"], "the simulation lasts from hour 0 to hour 0"),
        (FORK, ["tracers", "--release", "source", "--map", "map.png"], "must end in .svg"),
        (FORK, ["fleet", "--release", "source", "--branch", "up"], "no such side; known: bottom, side, top"),
        (FORK, ["fleet", "--release", "source", "--agent", "sphere:x"], "a sphere is named by its diameter"),
        (FORK, ["fleet", "--release", "source", "--run", "nowhere"], "nowhere: no such run directory"),
        (FORK, [*TRACERS, "--pipes", "town.csv", "--by", "colour"], "--by colour: no such column"),
        (FORK, [*TRACERS, "--pipes", "town.csv", "--weight", "material"], "weight 'iron': expected a number"),
        (UNKNOWN_LINK, [*TRACERS, "--pipes", "town.csv"], "town.csv: line 2: town has no link 'main'"),
        (FORK, [*TRACERS, "--receiver", "nowhere"], "--receiver nowhere: town has no such node"),
        (FORK, [*TRACERS, "--within", "soon"], "expected a time such as 8h"),
        (FORK, [*TRACERS, "--gis", "gis", "--crs", "Gauss"], "--crs Gauss: expected the number"),
        (FORK, [*TRACERS, "--open", "ahead"], "--open ahead: expected NAME=VALUE"),
        (FORK, [*TRACERS, "--steady", "3"], "the simulation lasts from hour 0 to hour 0"),
        (FORK, [*TRACERS, "--walks", "0", "--within", "1h"], "--walks 0: where flows change, or end"),
    ],
)
def test_wrong_input_is_one_line_that_names_the_fault(text, words, expected, refused):
    Path("town.inp").write_text(text)
    Path("town.csv").write_text("pipe,material\nmain,iron\n")
    assert expected in refused(words[0], "town.inp", *words[1:])
