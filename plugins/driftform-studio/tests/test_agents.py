"""Agents on the page: their facts are those of the command line, and so are their files."""

import io
import json
import subprocess
import zipfile

import pytest

from driftform.api import Run
from driftform.design.opening import open_agent


def test_an_agent_is_shown_as_its_run_found_it(finished, finished_folder):
    shown = finished.perform("api/runs/small/agents/near", {})
    run = Run.open(finished_folder / "small")
    best = run.best()["near"]
    assert shown["promise"]["nominal"] == pytest.approx(best["nominal"], abs=1e-9)
    assert [shown["promise"][key] for key in ("median", "p90", "flights")] == [best["median"], best["p90"], 20]
    design = open_agent(f"{finished_folder / 'small'}:near")
    assert shown["facts"]["mass"] == design.mass.mass and shown["facts"]["length"] == design.length
    assert len(shown["flight"]["t"]) > 100
    assert {effect["name"] for effect in shown["effects"]} >= {"release angle", "drag"}


def test_a_click_on_the_map_gives_the_agent_that_pick_gives(finished, finished_folder, program):
    point = [4.5, 0.0, 0.25]
    picked = finished.perform("api/runs/small/pick", {"point": point})
    words = ["pick", "small", *map(str, point), "--json", "--out", "elsewhere"]
    found = subprocess.run([program, *words], cwd=finished_folder, capture_output=True, text=True, check=True)
    command = json.loads(found.stdout)
    assert picked["key"] == "4.5_0_0.25"
    assert (picked["evaluation"], picked["distance"]) == (command["evaluation"], command["distance"])
    shown = finished.perform("api/runs/small/agents/4.5_0_0.25", {})
    assert shown["target"] is None and shown["point"] == point and shown["promise"]["flights"] == 0
    assert shown["promise"]["nominal"] == pytest.approx(picked["distance"], abs=1e-6)
    promised = finished.perform("api/runs/small/agents/4.5_0_0.25/disturb", {})["promise"]
    assert promised["flights"] == 20 and promised["median"] <= promised["p90"]


def test_the_map_is_that_of_the_run(finished):
    reach = finished.perform("api/runs/small/reach", {})
    assert (reach["columns"], reach["rows"]) == (90, 20)
    assert len(reach["classes"]) == 1800 and reach["flights"] == 30
    assert sum(kind >= 0 for kind in reach["classes"]) == reach["reached"] > 100
    assert max(reach["classes"]) < len(reach["colours"]) == len(reach["bounds"]) + 1


@pytest.mark.parametrize("kind", ["stl", "3mf", "kit"])
def test_files_are_those_of_the_command_line(finished, finished_folder, tmp_path, kind, program):
    made = finished.perform(f"api/runs/small/agents/near/make/{kind}", {})
    status, headers, body = finished.send("GET", f"/{finished.token}/take/made/{made['made']}/{made['file']}")
    assert status == 200 and headers["content-disposition"].startswith("attachment")
    options = ["--kit"] if kind == "kit" else []
    format = "stl" if kind == "stl" else "3mf"
    words = ["export", f"{finished_folder / 'small'}:near", "--format", format, *options, "--out", tmp_path]
    subprocess.run([program, *words], check=True, capture_output=True)
    name = f"small-near.{format}"
    if made["file"].endswith(".zip"):
        with zipfile.ZipFile(io.BytesIO(body)) as archive:
            assert set(archive.namelist()) == {path.name for path in tmp_path.iterdir()}
            body = archive.read(name)
    expected = (tmp_path / name).read_bytes()
    if format == "stl":
        assert body == expected
    else:
        parts = [zipfile.ZipFile(io.BytesIO(data)).namelist() for data in (body, expected)]
        assert parts[0] == parts[1]


def test_the_agent_file_flies_as_the_agent_does(finished, tmp_path):
    shown = finished.perform("api/runs/small/agents/far", {})
    body = shown["file"]
    assert shown["name"] == "small-far"
    (tmp_path / "far.json").write_text(body)
    flight = open_agent(str(tmp_path / "far.json")).simulate()
    assert flight.fitness["far"] == pytest.approx(json.loads(body)["result"]["fitness"], abs=0.02)


def test_the_study_file_and_the_section_can_be_taken(finished, finished_folder):
    assert finished.ask("api/runs/small")["text"] == (finished_folder / "small" / "study.toml").read_text()
    status, headers, body = finished.send("GET", f"/{finished.token}/take/small/agents/near/section.svg")
    assert status == 200 and headers["content-type"].startswith("image/svg+xml") and b"<svg" in body


def test_what_does_not_exist_is_refused_in_a_line(finished, wait_for):
    for path in ("api/runs/smal", "api/runs/small/flights/99999"):
        [line] = finished.ask(path, status=422)["errors"]
        assert line
    assert "did you mean 'small'" in finished.ask("api/runs/smal", status=422)["errors"][0]
    task = finished.ask("api/runs/small/agents/nowhere", {})["task"]
    state = wait_for(lambda: (s := finished.ask(f"api/tasks/{task}"))["is_over"] and s)
    assert state["errors"] == ["small: has no agent 'nowhere'"]


@pytest.mark.parametrize(
    ("work", "document", "words"),
    [
        ("pick", {"point": [4, 0, 5]}, "lies outside the pipe"),
        *(("pick", {"point": point}, "three numbers") for point in (None, [1, 2], ["x", 0, 0], [1, 2, 3, 4])),
        *(("agents/near/trim", {"grams": grams}, "enter the grams") for grams in (None, 0, -3, "x", [1])),
        *(("agents/near/hang", {"grams": grams}, "enter the grams") for grams in (None, "x", [1])),
        ("agents/near/hang", {"grams": 0.1, "celsius": "x"}, "enter the grams"),
        ("agents/near/hang", {"grams": 1e4, "celsius": 20}, "hangs under water"),
    ],
)
def test_work_on_what_is_no_point_or_no_weight_is_refused_in_a_line(finished, wait_for, work, document, words):
    task = finished.ask(f"api/runs/small/{work}", document)["task"]
    [line] = wait_for(lambda: finished.ask(f"api/tasks/{task}")["errors"])
    assert words in line
    for name in ("nonsense", "agents/near/nonsense"):
        [line] = finished.ask(f"api/runs/small/{name}", {}, status=422)["errors"]
        assert "unknown" in line


def test_ballast_is_planned_for_the_weight_of_a_print(finished):
    shown = finished.perform("api/runs/small/agents/near", {})
    facts = shown["facts"]
    exact = 1000 * (facts["hull"] + facts["core"])
    found = finished.perform("api/runs/small/agents/near/trim", {"grams": exact - 0.5})
    missing = facts["mass"] - facts["hull"] - facts["core"] - facts["putty"] + 0.0005
    # The seat for a larger ball weighs something, too.
    assert found["ballast_mass"] == pytest.approx(missing, rel=0.02)
    assert found["misses"]["simulated"] == pytest.approx(shown["promise"]["nominal"], abs=2e-3)
    assert found["misses"]["untrimmed"] > 2 * found["misses"]["trimmed"]


def test_an_agent_is_weighed_in_water(finished):
    found = finished.perform("api/runs/small/agents/near/hang", {"grams": 0.4, "celsius": 12.0})
    assert found["lines"][0].startswith("it weighs +0.40 g in water of 12 degrees C, and should weigh")
    assert set(found["misses"]) == {"simulated", "untrimmed", "trimmed"}
