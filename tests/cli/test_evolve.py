"""``driftform evolve`` from the outside: what it prints, what it leaves, and that both are true."""

import csv
import json
import tomllib
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from driftform.study import load_study
from driftform.study.sources import read_scenarios

pytestmark = pytest.mark.long

BEST = ("agent.json", "trajectory.csv", "section.svg", "agent.stl")


def test_stdout_is_one_json_document_with_the_fields_of_the_contract(finished_run):
    directory, result = finished_run
    document = json.loads(result.stdout)
    assert document.keys() >= {"run", "evaluations", "failed", "seconds", "targets"}
    assert document["run"] == "run"
    assert (document["evaluations"], document["failed"]) == (20, 0)
    assert document["seconds"] > 0
    assert list(document["targets"]) == ["TP1", "TP7"]
    for target, best in document["targets"].items():
        assert 0 < best["fitness"] <= 100
        assert best["error_percent"] == pytest.approx(100 - best["fitness"], abs=1e-12)
        assert (directory.parent / best["agent"]) == directory / "best" / target / "agent.json"
        assert all((directory.parent / path).is_file() for path in best["files"])


def test_off_a_terminal_progress_is_a_plain_line_on_stderr(finished_run):
    lines = finished_run[1].stderr.splitlines()
    if lines[0].startswith("compiling"):
        lines = lines[1:]
    # On a slow machine there is a line every ten seconds besides.
    states = [line.partition(": ")[2] for line in lines]
    assert [state for state in states if state.startswith("20/20 evaluations")] == [states[-1]]
    assert "\x1b" not in finished_run[1].stderr


def test_a_run_directory_holds_what_the_design_says(finished_run):
    directory, _ = finished_run
    best = {f"best/{target}/{name}" for target in ("TP1", "TP7") for name in BEST}
    top = {"study.toml", "resolved.toml", "environment.json", "run.db", "ended.json"}
    top |= {"figures/overview.svg", "figures/reach.svg"}
    found = {path.relative_to(directory).as_posix() for path in directory.rglob("*") if path.is_file()}
    assert found - {".lock"} == best | top


def test_a_run_keeps_its_study_as_given_and_resolved_with_versions_plugins_and_the_seed(finished_run):
    assert (finished_run[0] / "study.toml").read_text() == read_scenarios()["paper"]
    path = finished_run[0] / "resolved.toml"
    study = load_study(str(path))
    assert study.document == tomllib.loads(path.read_text())
    assert (study.seed, study.evaluations, study.scenario.target_names) == (1, 20, ("TP1", "TP7"))
    document = json.loads((finished_run[0] / "environment.json").read_text())
    assert document["seed"] == 1
    assert {row["name"] for row in document["plugins"]} >= {"lsystem", "frusta", "striptheory", "native"}
    assert document["packages"]["numpy"] != "?"
    assert len(document["sources"]["sources of driftform"]) == 12


def test_pictures_are_svg_and_the_flight_is_a_table_that_starts_at_the_release(finished_run):
    directory, _ = finished_run
    for path in directory.rglob("*.svg"):
        assert ET.parse(path).getroot().tag == "{http://www.w3.org/2000/svg}svg"
    with (directory / "best" / "TP1" / "trajectory.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [float(table[0][key]) for key in ("t", "x", "y", "z")] == [0.0, 0.0, 0.0, 0.0]
    times = [float(row["t"]) for row in table]
    assert times == sorted(set(times))


@pytest.mark.parametrize("agent", ["run/best/TP1/agent.json", "run:TP1"])
def test_simulate_finds_the_fitness_of_the_run_again(finished_run, run, agent, tmp_path):
    directory, result = finished_run
    again = run("simulate", agent, "--json", "--out", tmp_path / "flight", cwd=directory.parent)
    assert again.returncode == 0, again.stderr
    known = json.loads(result.stdout)["targets"]["TP1"]["fitness"]
    assert json.loads(again.stdout)["fitness"]["TP1"] == pytest.approx(known, abs=1e-9)


def test_two_workers_find_what_one_finds_to_the_last_digit(finished_run, run, rows, tmp_path):
    result = run(
        *("evolve", "paper", "--target", "TP1", "--target", "TP7", "--simulator", "native", "--evaluations", 20),
        *("--seed", 1, "--workers", 2, "--out", "run"),
        cwd=tmp_path,
    )
    assert result.returncode == 0, result.stderr
    assert rows(tmp_path / "run") == rows(finished_run[0])


def test_without_json_a_table_and_where_the_files_are(call, fakes):
    result = call("evolve", "paper", "--evaluations", 3, "--seed", 7, "--workers", 1, "--simulator", "fake")
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    assert lines[0].split()[:1] == ["target"]
    assert [line.split()[0] for line in lines[1:11]] == [f"TP{n}" for n in range(1, 11)]
    assert "of 10 targets are reached" in lines[11]
    assert lines[12].startswith("3 evaluations (0 failed) in ")
    assert lines[12].endswith("seed 7")
    assert Path("runs/paper-1/figures/overview.svg").is_file()


def test_a_seed_that_was_drawn_is_recorded(call, fakes):
    args = ("evolve", "paper", "--evaluations", 2, "--workers", 1, "--simulator", "fake", "--json")
    documents = [json.loads(call(*args).stdout) for _ in range(2)]
    assert [document["run"] for document in documents] == [f"runs/paper-{n}" for n in (1, 2)]
    for document in documents:
        environment = json.loads((Path(document["run"]) / "environment.json").read_text())
        assert environment["seed"] == document["seed"]
    assert documents[0]["seed"] != documents[1]["seed"]


def test_a_format_that_cannot_hold_an_agent_is_told_at_the_end_and_keeps_nothing_else_back(call, fakes):
    result = call(
        *("evolve", "paper", "--target", "TP1", "--target", "TP2", "--evaluations", 2, "--seed", 1, "--workers", 1),
        *("--simulator", "fake", "--out", "run", "--json", "--set", 'run.formats=["refusing", "stl"]'),
    )
    assert result.exit_code == 1
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 2
    assert "run/best/TP1/agent.never" in errors[0]
    assert "this agent is too pretty" in errors[0]
    assert {Path(p).name for p in json.loads(result.stdout)["targets"]["TP2"]["files"]} == set(BEST)
    assert Path("run/figures/overview.svg").is_file()


def test_a_study_file_of_ones_own_is_evolved(call, fakes):
    text = 'base = "paper"\n[targets]\nleak = [4.0, 0.0, -0.9]\n[simulator]\nuse = "fake"\n'
    Path("my study.toml").write_text(text)
    result = call("evolve", "my study.toml", "--evaluations", 2, "--workers", 1, "--json")
    document = json.loads(result.stdout)
    assert document["run"] == "runs/my study-1"
    assert list(document["targets"]) == ["leak"]
    assert (Path(document["run"]) / "study.toml").read_text() == text


def test_in_turbulent_flow_each_evaluation_has_gusts_of_its_own_and_its_agent_flies_the_same_again(run, tmp_path):
    study = tmp_path / "gusty.toml"
    study.write_text(
        'base = "paper"\n[flow]\nkind = "turbulent"\n[simulator]\nuse = "native"\n[flight]\nhorizon = 3.0\n'
    )

    def evolved(name, workers):
        given = ("--target", "TP2", "--evaluations", 12, "--strategy", "random", "--seed", 4, "--out", name)
        result = run("evolve", study, *given, "--workers", workers, "--json", cwd=tmp_path)
        assert result.returncode == 0, result.stderr
        document = json.loads(result.stdout)
        assert document["failed"] == 0
        best = document["targets"]["TP2"]
        return best

    alone, together = evolved("alone", 1), evolved("together", 2)
    assert alone["fitness"] == together["fitness"]
    agent = json.loads((tmp_path / alone["agent"]).read_text())
    assert agent["environment"]["gusts"]["seed"] != 0
    again = run("simulate", tmp_path / alone["agent"], "--json", cwd=tmp_path)
    assert json.loads(again.stdout)["fitness"]["TP2"] == alone["fitness"]
    still = run("simulate", tmp_path / alone["agent"], "--json", "--set", "gusts.seed=1", cwd=tmp_path)
    assert json.loads(still.stdout)["fitness"]["TP2"] != alone["fitness"]
