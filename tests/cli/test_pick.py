"""``driftform pick``: the agent whose flight passes closest to any point."""

import json
import shutil
import sqlite3
from dataclasses import replace

import numpy as np
import pytest

from driftform.motion.path.approach import closest_approach
from driftform.runs.directory import lock_run
from driftform.runs.store import Record, Store
from driftform.types import Candidate, Evaluation, Genome

ANYWHERE = ("4.2", "0", "-0.35")


@pytest.fixture(scope="module")
def flights(finished_run):
    with Store.open(finished_run[0] / "run.db", read_only=True) as store:
        return dict(store.read_trajectories())


def test_it_finds_what_a_search_through_all_flights_finds(call, run_copy, flights):
    result = call("pick", run_copy, *ANYWHERE, "--json")
    told = json.loads(result.stdout)
    point = np.array([[float(value) for value in ANYWHERE]])
    distances = {index: closest_approach(flight, point)[0][0] for index, flight in flights.items()}
    best = min(distances, key=distances.__getitem__)
    assert told["evaluation"] == best
    assert told["distance"] == distances[best]
    assert told["point"] == [4.2, 0.0, -0.35]


def test_the_agent_serves_other_commands_and_flies_past_the_point_again(call, run_copy):
    picked = json.loads(call("pick", run_copy, *ANYWHERE, "--json").stdout)
    place = ", ".join(ANYWHERE).replace("0,", "0.0,")
    flown = call("simulate", picked["agent"], "--set", f"targets={{here=[{place}]}}", "--json")
    assert flown.exit_code == 0, flown.output
    here = json.loads(flown.stdout)["closest"]["here"]
    # The stored flight is thinned to single precision.
    assert here["distance"] == pytest.approx(picked["distance"], abs=1e-4)
    assert here["t"] == pytest.approx(picked["t"], abs=1e-3)


@pytest.mark.parametrize("z", ["-0.9", "-9e-1", "-.9"])
def test_a_negative_coordinate_is_no_option_and_options_may_stand_before(call, run_copy, z):
    told = json.loads(call("pick", run_copy, "4.0", "-0.0", z, "--json").stdout)
    assert told["point"][2] == -0.9
    assert json.loads(call("pick", "--json", run_copy, "4", "0", "-.9").stdout)["point"] == [4.0, 0.0, -0.9]


def test_the_database_is_left_as_it_is_also_where_another_process_works_on_the_run(call, run_copy):
    before = (run_copy / "run.db").read_bytes()
    with lock_run(run_copy):
        assert call("pick", run_copy, *ANYWHERE).exit_code == 0
    assert (run_copy / "run.db").read_bytes() == before


@pytest.mark.parametrize(
    ("point", "told"),
    [
        (("4", "0", "-1.2"), "X Y Z = 4 0 -1.2 lies outside the pipe, from [0.0, 0.0, 0.0] to [9.0, "),
        (("-0.5", "0", "0"), "lies outside the pipe"),
        (("nan", "0", "0"), "X Y Z = nan 0 0: should be three finite numbers"),
        (("4", "0", "inf"), "should be three finite numbers"),
        (("4", "0", "up"), "Invalid value for 'Z'"),
        (("4", "0"), "a point is named by X Y Z, its coordinates in m, or by --place"),
        (("4", "0", "0", "--jsn"), "--jsn"),
    ],
)
def test_a_point_that_is_none_is_refused(refused, run_copy, point, told):
    assert told in refused("pick", run_copy, *point)


def test_a_run_without_a_sound_flight_has_nothing_to_pick(refused, run_copy, tmp_path):
    with Store.open(run_copy / "run.db") as store:
        document = store.read_study()
    shutil.rmtree(run_copy)
    run_copy.mkdir()
    genome = Genome("lsystem", ())
    with Store.create(run_copy / "run.db", document) as store:
        failed = Evaluation.failed(genome, 2, "it broke")
        store.add([Record(0, Candidate(genome), failed)], ("TP1", "TP7"))
    line = refused("pick", run_copy, *ANYWHERE)
    assert "has no evaluation yet that did not fail" in line and "driftform resume" in line


def test_an_unchecked_flight_is_flown_again_and_may_turn_out_not_to_be_the_closest(call, run_copy, flights):
    before = json.loads(call("pick", run_copy, *ANYWHERE, "--json").stdout)
    worse = next(index for index in flights if index != before["evaluation"])
    flight, point = flights[worse], np.array([float(value) for value in ANYWHERE])
    with Store.open(run_copy / "run.db") as writer:
        # It claims to pass the point exactly, but its genome is that of another flight.
        claimed = replace(flight, position=flight.position - flight.position[len(flight.t) // 2] + point, error=None)
        other = writer.read_record(worse, ("TP1", "TP7"))
        genome = other.candidate.genome
        record = Record(20, Candidate(genome), Evaluation(genome, np.zeros(2), claimed), other.seed)
        writer.add([record], ("TP1", "TP7"))
    assert json.loads(call("pick", run_copy, *ANYWHERE, "--json").stdout) == before


def test_an_unchecked_flight_is_picked_with_the_distance_of_its_checked_flight(call, run_copy):
    before = json.loads(call("pick", run_copy, *ANYWHERE, "--json").stdout)
    with sqlite3.connect(run_copy / "run.db") as connection:
        connection.execute("UPDATE evaluation SET error = NULL")
    after = json.loads(call("pick", run_copy, *ANYWHERE, "--json").stdout)
    assert after == before
