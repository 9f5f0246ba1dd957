"""``driftform export-flight``: flights in the formats that are installed, and what is refused."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

WORD = "addB-tiltn-1-M-moveB-addB-tiltp-1-L-moveB"
QUICK = ("--scenario", "paper", "--simulator", "native")


@pytest.mark.peers
def test_a_flight_in_four_formats(call):
    import polars

    formats = ("--format", "csv,parquet,mcap,rosbag1,rosbag2")
    result = call("export-flight", WORD, *formats, *QUICK, "--rate-hz", "20", "--out", "f", "--json")
    assert result.exit_code == 0, result.stderr
    told = json.loads(result.stdout)
    assert {file["format"] for file in told["files"]} == {"csv", "parquet", "mcap", "rosbag1", "rosbag2"}
    assert all(Path(file["path"]).stat().st_size for file in told["files"])
    assert told["simulator"] == "native" and told["end"]["reason"] == "outlet"
    paths = {file["format"]: file["path"] for file in told["files"]}
    frame = polars.read_parquet(paths["parquet"])
    assert len(frame) == told["samples"] and frame["t"][-1] == told["end"]["t"]
    counts = next(file["topics"] for file in told["files"] if file["format"] == "mcap")
    assert counts["/tf"] == told["samples"] and counts["/agent/markers"] == 1
    # All is in the directory that was asked for, and only what was told of.
    found = {str(path) for path in Path("f").rglob("*") if path.is_file()}
    assert found == {file["path"] for file in told["files"]}


@pytest.mark.long
def test_it_is_the_flight_that_simulate_shows(call):
    assert call("simulate", WORD, *QUICK, "--out", "s").exit_code == 0
    assert call("export-flight", WORD, *QUICK, "--rate-hz", "0", "--out", "f").exit_code == 0
    [path] = Path("f").glob("*.csv")
    with path.open() as one, Path("s/trajectory.csv").open() as other:
        flight, shown = list(csv.reader(one)), list(csv.reader(other))
    assert flight[0][: len(shown[0])] == shown[0]
    assert np.array([row[:14] for row in flight[1:]], float) == pytest.approx(
        np.array(shown[1:], float), rel=1e-5, abs=1e-6
    )


def test_a_rate_gives_samples_that_are_evenly_apart(call):
    result = call("export-flight", WORD, *QUICK, "--rate-hz", "50", "--json")
    assert result.exit_code == 0, result.stderr
    told = json.loads(result.stdout)
    with Path(told["files"][0]["path"]).open() as file:
        t = np.array([row["t"] for row in csv.DictReader(file)], float)
    assert np.diff(t)[:-1] == pytest.approx(0.02)
    assert t[-1] == told["end"]["t"] and len(t) == told["samples"]
    assert Path(told["files"][0]["path"]).parent.parent == Path("flights")


@pytest.mark.peers
def test_options_of_a_recorder_and_another_scenario(call):
    result = call(
        *("export-flight", WORD, "--scenario", "leak-search", "--format", "mcap", "--json"),
        *("--set", "recorder.mcap.namespace=diver", "--rate-hz", "5"),
    )
    assert result.exit_code == 0, result.stderr
    [file] = json.loads(result.stdout)["files"]
    assert "/diver/concentration" in file["topics"] and "/diver/odom" in file["topics"]


def test_a_flight_that_failed_is_written_and_told_as_failed(call):
    result = call("export-flight", WORD, *QUICK, "--set", "simulator.step_limit=20", "--out", "f")
    assert result.exit_code == 1
    assert "step limit" in result.stderr and "the files hold the flight until then" in result.stderr
    assert len(list(Path("f").iterdir())) == 1


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("--format", "parqet"), "did you mean 'parquet'?"),
        (("--format", ","), "--format is empty"),
        (("--rate-hz", "-1"), "should be from 0"),
        (("--rate-hz", "nan"), "should be from 0"),
        pytest.param(("--set", "recorder.mcap.leek_rate=1"), "did you mean 'leak_rate'?", marks=pytest.mark.peers),
        (("--set", "recorder.parqet.seed=1"), "did you mean 'parquet'?"),
        pytest.param(("--set", "recorder.mcap.namespace=a/b"), "namespace", marks=pytest.mark.peers),
        (("--scenario", "pipe-inspektion"), "did you mean 'pipe-inspection'?"),
    ],
)
def test_what_is_wrong_is_one_line(refused, arguments, reason):
    assert reason in refused("export-flight", WORD, *QUICK, *arguments)
