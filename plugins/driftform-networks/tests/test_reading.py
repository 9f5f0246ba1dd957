"""Files as utilities have them: their letters, their faults, and changes to the model without editing them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from driftform.errors import InputError
from driftform_networks.flights.bodies import open_traveller
from driftform_networks.flights.travelling import Travel
from driftform_networks.hydraulics.epanet import Changes, open_network
from driftform_networks.passages.passage import find_reachable
from driftform_networks.planning.following import route, trace

FORK = Path(__file__).with_name("fork.inp").read_text()
UNITS = FORK.replace(" Units LPS\n", "")

IN_A_ROW = Path(__file__).with_name("in_a_row.inp").read_text()
"""Reservoirs in a row: water of the first reaches the second, and no pipe beyond it."""

PUMPED = Path(__file__).with_name("pumped.inp").read_text()


def write(folder, text, encoding="utf-8"):
    path = folder / "town.inp"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(
    ("name", "encoding"),
    [
        ("fork", "utf-8-sig"),
        ("fork", "utf-16"),
        ("Depósito", "latin-1"),
        ("Depósito", "utf-8"),
        ("节点", "gbk"),
        ("节点", "utf-16"),
        ("Nœud", "cp1252"),
    ],
)
def test_names_are_read_in_the_letters_in_which_they_were_written(name, encoding, tmp_path):
    network = open_network(write(tmp_path, FORK.replace("fork", name), encoding), tmp_path)
    assert network.nodes[0] == name
    assert trace(network, "source", walks=0).probability[0] == 1


def test_a_file_without_units_has_those_of_epanet(tmp_path):
    """EPANET's default is GPM, with feet and inches."""
    network = open_network(write(tmp_path, UNITS), tmp_path)
    assert "no Units in [OPTIONS]: flows are GPM" in network.hydraulics.warnings[0]
    assert network.length == pytest.approx(200 * 0.3048)
    assert network.diameter == pytest.approx(300 * 0.0254)
    assert network.hydraulics.flow[0] == pytest.approx(np.array([30, 20, 10]) * 6.30901964e-05, rel=2e-5)


def test_what_lies_behind_a_node_carries_its_peak_demand_at_a_metre_a_second(tmp_path):
    network = open_network(write(tmp_path, FORK), tmp_path)
    wide = network.peak_demand > np.pi / 4 * 0.02**2
    assert wide.any()
    assert np.pi / 4 * network.offtakes[wide] ** 2 == pytest.approx(network.peak_demand[wide])


def test_the_time_of_the_day_at_which_a_simulation_begins_is_read(tmp_path):
    assert open_network(write(tmp_path, PUMPED), tmp_path).hydraulics.clock == 6 * 3600


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (FORK.replace("side fork branch 200", "side fork branch 0"), "line 11: Error 202: illegal numeric value 0"),
        (FORK.replace("fork 10 0", "fork 10 nan"), "the demand of fork is nan, perhaps by line 3: nan"),
        (FORK.replace("main source fork 200", "main source fork 1e308"), "the length of main is inf, perhaps by line 9: 1e308"),
        (FORK.replace("fork", "f" * 300), "of 300 letters"),
        (FORK.replace("fork", "f" * 32), "Error 252: invalid ID name"),
        (FORK.replace("Duration 0", "Duration 24000000"), "at most 100000 steps are read: shorten Duration"),
        (FORK.replace("[PIPES]", "[PYPES]"), "Error 299: invalid section keyword"),
        (FORK.replace("[OPTIONS]", "[RULES]\nRULE 1\nIF TANK none LEVEL > 8\nTHEN PIPE on STATUS IS CLOSED\n[OPTIONS]"), "Error 200: one or more errors in input file, perhaps in [RULES]"),
        ("", "Error 223: not enough nodes"),
    ],
)  # fmt: skip
def test_a_file_that_epanet_cannot_run_is_one_line_that_names_what_is_wrong(text, expected, tmp_path, refused):
    assert expected in refused("show", write(tmp_path, text))


def test_names_that_a_spreadsheet_takes_for_formulas_are_warned_of(tmp_path, done):
    path = write(tmp_path, FORK.replace("ahead", "=ahead"))
    document = done("tracers", path, "--release", "source", "--tables", "tables", "--json")
    assert any("takes '=ahead' for a formula" in line for line in document["warnings"])


def test_negative_pressures_are_a_warning_with_nodes_and_values(tmp_path, done):
    path = write(tmp_path, FORK.replace("source 60", "source 9"))
    for words in (["show"], ["tracers", "--release", "source"]):
        told = done(words[0], path, *words[1:])
        assert "negative pressure at 2 junctions that deliver water, the lowest at hour 0: " in told
        assert "ahead -1." in told


def test_absurd_bores_and_speeds_are_warnings_and_bores_in_metres_end_a_trip(tmp_path, call, done):
    shown = done("show", write(tmp_path, FORK.replace("branch 200 300", "branch 200 12")))
    assert "1 bores are not from 20 mm to 4 m: side 12 mm" in shown
    assert "1 pipes are faster than 10 m/s: side 88.4 m/s" in shown
    result = call("tracers", write(tmp_path, FORK.replace(" 300 ", " 0.3 ")), "--release", "source")
    assert result.exit_code == 2 and "the median bore is 0.3 mm" in result.stderr


def test_a_network_that_lacks_a_source_is_shown_and_not_travelled(tmp_path, call, done):
    path = write(tmp_path, FORK.replace("200 300 100 0 Open\n on", "200 300 100 0 Closed\n on"))
    done("show", path)
    assert call("tracers", path, "--release", "source").exit_code == 2


def test_reservoirs_end_what_water_of_another_one_reaches(tmp_path):
    network = open_network(write(tmp_path, IN_A_ROW), tmp_path)
    names = {link for link, reached in zip(network.links, find_reachable(network, network.find_node("high"), [0]), strict=True) if reached}  # fmt: skip
    assert names == {"one", "two"}
    passage = trace(network, "high", walks=200)
    assert passage.coverage == pytest.approx(network.length[:2] @ passage.seen[:2] / 1000)
    assert passage.probability[network.find_node("b")] == 0


def test_a_pump_ends_a_trip_and_the_table_names_it(tmp_path, done):
    path = write(tmp_path, PUMPED)
    document = done("route", path, "sphere:60mm", "--release", "well", "--buoyancy-error", 0, "--json")
    assert set(document["nodes"]) == {"well", "before"}
    [end] = document["stuck"]
    assert (end["place"], end["probability"]) == ("lift", pytest.approx(1))
    assert end["reason"] == "before a pump that lets no body pass (release behind it, at behind)"


def test_a_valve_lets_bodies_pass_that_fit_its_opening_and_is_listed(tmp_path):
    network = open_network(write(tmp_path, PUMPED), tmp_path)
    travel = Travel(clearance={"pump": 1.0})
    spheres = [replace(open_traveller(f"sphere:{size}mm"), error=0.0) for size in (70, 80)]
    narrow, wide = (route(network, one, "well", travel=travel, walks=0, cache=tmp_path) for one in spheres)
    # A quarter of 300 mm.
    assert narrow.gates["reducer"] == ("pressure reducing valve, 75 of 300 mm open", pytest.approx(1))
    assert wide.stuck[0].place == "reducer"
    assert wide.stuck[0].reason == "in a pressure reducing valve, too wide: 80 mm in a bore of 75 mm"
    by_name = Travel(clearance={"pump": 1.0, "reducer": 0.5})
    assert route(network, spheres[1], "well", travel=by_name, walks=0, cache=tmp_path).gates["reducer"]


def test_tracers_of_a_network_that_divides_nowhere_are_followed(tmp_path):
    text = FORK.replace(" side fork branch 200 300 100 0 Open\n", "").replace(" branch 10 10\n", "")
    passage = trace(open_network(write(tmp_path, text.replace(" branch 200 -100\n", "")), tmp_path), "source")
    assert passage.probability == pytest.approx([1, 1, 1])


def open_changed(folder, text=FORK, **changes):
    return open_network(write(folder, text), folder, Changes(**changes))


def test_a_closed_pipe_carries_nothing_and_an_open_hydrant_draws_its_flow(tmp_path):
    network = open_changed(tmp_path, FORK.replace("branch 10 10", "branch 10 0"), close=("side",))
    assert network.hydraulics.flow[0] == pytest.approx([0.02, 0.02, 0], abs=1e-9)
    network = open_changed(tmp_path, open={"branch": 5.0})
    assert network.hydraulics.flow[0] == pytest.approx([0.035, 0.02, 0.015], abs=1e-9)


def test_what_is_closed_stays_closed_whatever_controls_and_rules_want(tmp_path):
    """With a loop, so that closing one pipe cuts nobody off."""
    text = FORK.replace("[OPTIONS]", " loop ahead branch 200 300 100 0 Open\n[CONTROLS]\n LINK side OPEN AT TIME 1\n"
        "[RULES]\nRULE 1\nIF SYSTEM TIME > 2\nTHEN PIPE side STATUS IS OPEN\n[OPTIONS]").replace("Duration 0", "Duration 5")  # fmt: skip
    with pytest.raises(InputError, match=r"shorten Duration in \[TIMES\]$"):
        open_changed(tmp_path, text.replace("Duration 5", "Duration 5000000"))
    network = open_changed(tmp_path, text, close=("side",))
    side = network.links.index("side")
    assert len(network.hydraulics.times) >= 5
    assert np.abs(network.hydraulics.flow[:, side]).max() < 1e-7
    assert np.abs(open_changed(tmp_path, text).hydraulics.flow[:, side]).min() > 1e-3


@pytest.mark.parametrize("units", ["LPS", "GPM"])
def test_a_reducing_valve_keeps_the_pressure_that_it_is_set_to(units, tmp_path):
    text = PUMPED.replace("LPS", units)
    network = open_changed(tmp_path, text, valves={"reducer": 12.0})
    tap = network.find_node("tap")
    assert network.hydraulics.head[0, tap] - network.elevation[tap] == pytest.approx(12, rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"close": ("sied",)}, "--close sied: no such link"),
        ({"open": {"source": 1.0}}, "--open source: it is a reservoir"),
        ({"valves": {"side": 3.0}}, "--set-valve side: not a valve"),
    ],
)
def test_a_change_that_the_network_does_not_have_is_refused(changes, expected, tmp_path):
    with pytest.raises(InputError, match=expected):
        open_changed(tmp_path, **changes)
