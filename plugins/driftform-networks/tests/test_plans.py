"""Plans: nets against all choices of them, what receivers hear and pipes are worth, and maps that other programs read."""

import shutil
import subprocess
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.errors import InputError
from driftform_networks.commands import parse_hours, read_names
from driftform_networks.flights.bodies import open_traveller
from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.planning.fleets import plan_fleet
from driftform_networks.planning.following import route, trace
from driftform_networks.planning.plans import catch, choose_nets, plan_inspection
from driftform_networks.planning.sights import find_heard, group_sight, read_pipes, read_weights


@given(seed=st.integers(0, 2**32 - 1), places=st.integers(1, 5), size=st.integers(1, 3))
@settings(max_examples=60, deadline=None)
def test_no_choice_of_nets_is_worth_more_than_the_bound(seed, places, size):
    """And exchanging one net for another does not improve the choice."""
    rng = np.random.default_rng(seed)
    times = rng.random((places, 7))
    # A body sees more until it comes to a later net.
    worth = np.take_along_axis(np.sort(rng.random((places, 7)), axis=0), times.argsort(axis=0).argsort(axis=0), axis=0)
    times[rng.random(times.shape) < 0.4] = np.inf
    chosen, value, bound = choose_nets(times, worth, size)
    assert value == pytest.approx(catch(times[chosen], worth[chosen])[0].sum())
    count = min(size, places)
    every = [
        catch(times[list(rows)], worth[list(rows)])[0].sum()
        for most in range(1, count + 1)
        for rows in combinations(range(places), most)
    ]
    assert value <= max(every) + 1e-9 and max(every) <= bound + 1e-9
    _, caught, most = choose_nets(times, np.ones_like(times), size)
    best = max(np.isfinite(times[list(rows)]).any(axis=0).sum() for rows in combinations(range(places), count))
    assert (1 - 1 / np.e) * best - 1e-9 <= caught <= best <= most + 1e-9


def test_a_net_at_the_end_of_each_branch_catches_all_that_the_bodies_have_seen(fork_file, tmp_path):
    network, bodies = open_network(fork_file, tmp_path), [replace(open_traveller("sphere:30mm"), error=0.0)]
    found = plan_inspection(network, bodies, ["source"], 2, size=1, walks=400, cache=tmp_path)
    assert set(found.nets) == {"ahead", "branch"}
    assert found.catches.sum() == 1
    shares = route(network, bodies[0], "source", walks=0, cache=tmp_path).probability
    expected = [shares[network.find_node(net)] for net in found.nets]
    assert found.catches == pytest.approx(expected, abs=4 * np.sqrt(0.25 / 400))
    assert found.measure(found.recorded) == found.measure(found.alone) == pytest.approx(2 / 3)
    [one] = plan_inspection(network, bodies, ["source"], 1, size=1, walks=400, aim="caught", cache=tmp_path).nets
    assert one == "fork"


def test_nothing_is_seen_after_the_battery_nor_caught_after_the_shift(fork_file, tmp_path):
    network, bodies = open_network(fork_file, tmp_path), [replace(open_traveller("sphere:30mm"), error=0.0)]
    # The water takes 470 s through the main, 707 s through the run and 1414 s through the branch.
    more = {"size": 1, "walks": 50, "demand_error": 0.0, "cache": tmp_path}
    short = plan_inspection(network, bodies, ["source"], 2, within=1.0, battery=0.15, **more)
    assert short.measure(short.alone) == pytest.approx(1 / 3)
    assert short.catches.sum() == 1
    late = plan_inspection(network, bodies, ["source"], 2, within=0.35, **more)
    assert set(late.nets) <= {"fork", "ahead"}
    passage = trace(network, "source", within=0.35, walks=400)
    assert {end.kind for end in passage.ends} == {"demand", "under way"}


@pytest.mark.parametrize("hour", [0.0, 12.0])
def test_a_battery_lasts_as_long_at_any_hour_of_release(hour, fork_file, tmp_path):
    path = tmp_path / "day.inp"
    path.write_text(fork_file.read_text().replace("Duration 0", "Duration 24:00"))
    more = {"size": 1, "walks": 50, "demand_error": 0.0, "cache": tmp_path}
    bodies = [replace(open_traveller("sphere:30mm"), error=0.0)]
    found = plan_inspection(
        open_network(path, tmp_path), bodies, ["source"], 2, hours=[hour], within=1.0, battery=0.15, **more
    )
    # The main alone: its end is reached after 470 s, that of the run after 1180 s.
    assert found.measure(found.recorded) == pytest.approx(1 / 3)
    assert found.value == pytest.approx(1)


def test_a_plan_of_net3_beats_random_nets_and_keeps_below_its_bound(done, epanet):
    words = ["plan", "Net3", "--release", "61,101,237", "--hours", "6,12", "--nets", 4, "--walks", 100]
    words += ["--agent", "sphere:5mm", "--buoyancy-error", 0]
    files = ["--gis", "gis", "--crs", "EPSG:25832", "--map", "plan.svg", "--tables", "tables", "--report", "plan.html"]
    document = done(*words, *files, "--json")
    assert len(document["members"]) == 3 and len(document["nets"]) == 4
    assert document["random"] + 0.2 < document["value"] <= document["bound"] <= 1
    assert document["recorded"] <= document["coverage_with_nets"] <= document["coverage"]
    assert all(Path(file).is_file() for file in document["files"])
    assert "net " in Path("plan.svg").read_text() and "viewBox" in Path("plan.html").read_text()


def test_fleets_in_changing_flows_keep_below_what_steering_sees(epanet, tmp_path):
    network, sphere = epanet.read_library("Net3"), [replace(open_traveller("sphere:5mm"), error=0.0)]
    more = {"within": 6.0, "walks": 200, "cache": tmp_path}
    found = plan_fleet(network, sphere, ["61"], 3, **more)
    assert (found.curve <= found.bound + 1e-9).all() and (np.diff(found.bound) >= -1e-9).all()
    # A narrow body that the water mixes is a tracer.
    assert found.curve == pytest.approx(found.tracers, abs=0.03)


def test_receivers_hear_along_the_pipes_and_not_across(fork_file, tmp_path):
    network = open_network(fork_file, tmp_path)
    at = [network.find_node("ahead")]
    assert find_heard(network, at, 150.0) == pytest.approx([0, 0.75, 0])
    assert find_heard(network, at, 300.0) == pytest.approx([0.5, 1, 0.5])
    both = [*at, network.find_node("source")]
    assert find_heard(network, both, 120.0) == pytest.approx([0.6, 0.6, 0])


def test_what_is_seen_is_counted_by_material_and_weighed_by_risk(fork_file, tmp_path, done):
    network = open_network(fork_file, tmp_path)
    Path("pipes.csv").write_text("pipe,material,risk\nmain,iron,1\non,iron,3\nside,lead,4\n")
    columns = read_pipes(Path("pipes.csv"), network)
    passage = trace(network, "source", walks=0)
    groups = group_sight(network, passage.seen, passage.reachable, columns["material"])
    assert groups == [("iron", 400, pytest.approx(5 / 6)), ("lead", 200, pytest.approx(1 / 3))]
    weighed = replace(network, weight=read_weights(columns, "risk"))
    assert trace(weighed, "source", walks=0).coverage == pytest.approx((1 + 3 * 2 / 3 + 4 / 3) / 8)
    options = [
        "--pipes",
        "pipes.csv",
        "--by",
        "material",
        "--by",
        "diameter",
        "--receiver",
        "ahead",
        "--range",
        150,
        "--gis",
        "gis",
    ]
    document = done("tracers", fork_file, "--release", "source", *options, "--json")
    assert [row["value"] for row in document["by"]["material"]] == ["iron", "lead"]
    assert [row["value"] for row in document["by"]["diameter"]] == ["0.3"]
    assert {Path(file).name for file in document["files"]} == {"links-unknown-crs.geojson", "nodes-unknown-crs.geojson"}
    assert document["in_range"] == pytest.approx(0.25)
    assert document["heard"] == pytest.approx(0.25 * 2 / 3)


def test_many_numbers_are_grouped_into_classes_of_about_equal_length(epanet):
    network = epanet.read_library("Net3")
    reachable, years = network.length > 0, [f"{1950 + row % 40}" for row in range(len(network.links))]
    groups = group_sight(network, np.full(len(years), 0.25), reachable, years)
    assert len(groups) == 5 and groups[0][0].startswith("1950")
    assert sum(length for _, length, _ in groups) == pytest.approx(network.length.sum())
    assert max(length for _, length, _ in groups) < 0.4 * network.length.sum()
    assert all(share == pytest.approx(0.25) for *_, share in groups)


def test_hydrants_are_read_with_a_heading_and_without(fork_file, tmp_path):
    network, path = open_network(fork_file, tmp_path), tmp_path / "hydrants.csv"
    path.write_text("hydrant;street\nfork;Main Street\n# closed\n\nahead;\n")
    assert read_names(path, network) == ["fork", "ahead"]
    path.write_text("fork\nnobody\n")
    with pytest.raises(InputError, match=r"line 2: fork has no node 'nobody'"):
        read_names(path, network)


@pytest.mark.parametrize("text", ["6-", "18-6", "a", "0-24/0"])
def test_hours_that_are_none_are_refused(text):
    with pytest.raises(InputError, match="expected hours such as"):
        parse_hours(text)


def test_clock_times_count_from_the_clock_at_which_the_simulation_begins(epanet):
    hydraulics = replace(epanet.read_library("Net3").hydraulics, clock=6 * 3600.0)
    assert hydraulics.format_clock(2.0, 900.0) == "08:15"
    assert hydraulics.format_clock(18.0, 3600.0) == "1 d 01:00"


def test_gdal_reads_the_maps_with_their_reference_system(epanet, tmp_path, done):
    if shutil.which("ogrinfo") is None:
        pytest.skip("ogrinfo of gdal-bin is not installed")
    folder = tmp_path / "gis"
    done("tracers", "Net3", "--release", "61", "--steady", 0, "--gis", folder, "--crs", "EPSG:25832")
    for name, kind, _count in (("nodes", "Point", 83), ("links", "Line String", None)):
        said = subprocess.run(["ogrinfo", "-al", "-so", folder / f"{name}.geojson"], capture_output=True, text=True, check=True).stdout  # fmt: skip
        assert f"Geometry: {kind}" in said and "ETRS89 / UTM zone 32N" in said
        assert int(said.partition("Feature Count: ")[2].split()[0]) > 80
    assert "seen: Real" in said
