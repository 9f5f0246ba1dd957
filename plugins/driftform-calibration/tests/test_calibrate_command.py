"""``driftform calibrate`` and ``driftform drop``: documents, files, and one line for each track that is broken."""

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from made_films import EXACT, film_flight, place_drop

from driftform.design.opening import open_agent
from driftform.study import load_study
from driftform.water import Factors

TRACKS = Path(__file__).parents[3] / "docs" / "tracks"
FACTORS = {"axial_drag", "cross_drag", "added_mass", "net_weight", "restitution", "friction"}
WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"

FILM = """\
base = "tank"
pipe.segments = [{start = [-50.0, 0.0, 97.0], end = [50.0, 0.0, 97.0], radius = 100.0}]
release = {pitch_deg = 30.0, position = [0.0, 0.0, -0.1]}
"""
"""The study of a film in a tank of 3 m."""


@pytest.fixture
def track(tmp_path):
    """The track of a sphere that settles, with the study of its film beside it."""
    for name in ("ten-cate-e4.csv", "ten-cate-e4.toml"):
        shutil.copy(TRACKS / name, tmp_path)
    return Path("ten-cate-e4.csv")


@pytest.mark.long
def test_the_document_has_factors_residual_and_files(done, track):
    found = done("calibrate", "C", track, "--fit", "cross_drag", "--out", "found", "--json")
    assert set(found["factors"]) == FACTORS
    for factor in found["factors"].values():
        assert {"value", "low", "high", "known"} <= set(factor)
        assert factor["known"] or (factor["value"] == 1.0 and factor["low"] is None and factor["reason"])
    drag = found["factors"]["cross_drag"]
    assert drag["known"] and drag["low"] < drag["value"] < drag["high"]
    assert 0 < found["residual"] < found["residual_before"]
    assert [Path(path).name for path in found["files"]] == [
        "calibration.toml",
        "agent.json",
        "report.html",
        "tracks.svg",
    ]
    table = tomllib.loads(Path("found/calibration.toml").read_text(encoding="utf-8"))
    assert table == {"calibration": found["calibration"]}
    page = Path("found/report.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 1 and "cross_drag = [" in page and 'class="seen"' in page
    # The agent remembers it, and any study takes it.
    remembered = done("inspect", "found/agent.json", "--json")["calibration"]
    assert remembered["cross_drag"]["value"] == pytest.approx(drag["value"], rel=1e-3)
    assert "calibrated cross drag" in done("inspect", "found/agent.json")
    study = load_study("pipe-inspection", calibration="found/calibration.toml")
    assert study.scenario.calibration.intervals["cross_drag"][0] == found["calibration"]["cross_drag"][0]


@pytest.mark.long
def test_a_body_of_ones_own_is_calibrated_by_its_film(call, done, write_track, tmp_path):
    shutil.copy(TRACKS.parent / "bodies" / "remus-100.csv", tmp_path)
    done("body", "remus-100.csv", "--mass", 40, "--cog", 0.6, "--scenario", "tank", "--out", "r.json")
    design = open_agent("r.json")
    bench = place_drop(design.pipeline, design.agent.morphology, 30.0, depth=3.0)
    film = film_flight(bench, Factors(cross_drag=1.3), np.random.default_rng(5), EXACT)
    Path("1.toml").write_text(FILM, encoding="utf-8")
    given = ("--fit", "cross_drag", "--out", "found", "--json")
    found = done("calibrate", "r.json", write_track(Path("1.csv"), film), *given)
    assert found["factors"]["cross_drag"]["value"] == pytest.approx(1.3, rel=0.03)
    assert "calibrated cross drag" in done("inspect", "found/agent.json")
    assert "--tank 1 0.5 0.5: the agent is 1.33 m long" in call("drop", "r.json").stderr


def test_people_read_factors_intervals_notes_and_the_next_step(done, track):
    rows = np.loadtxt(track, delimiter=",", skiprows=1)
    np.savetxt(track, rows[::-1], delimiter=",", header="t (s),z (mm)", comments="")
    told = done("calibrate", "C", track, "--fit", "cross_drag", "--out", "found")
    assert "cross drag" in told and "90 % interval" in told and "rows were put in the order of time" in told
    assert "next: driftform evolve --calibration found/calibration.toml" in told


@pytest.mark.parametrize(
    ("order", "names", "message"),
    [(1, "t,z", "give --unit mm"), (-1, "t (s),z (mm)", "upside down, or backwards: give --y-down")],
)
def test_a_track_in_another_unit_or_upside_down_is_refused(refused, track, order, names, message):
    rows = np.loadtxt(track, delimiter=",", skiprows=1)
    rows[:, 1] = rows[::order, 1]
    np.savetxt(track, rows, delimiter=",", header=names, comments="")
    line = refused("calibrate", "C", track)
    assert line.startswith("error: ten-cate-e4.csv: ") and message in line


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("absent.csv",), "absent.csv: cannot be read"),
        (("ten-cate-e4.csv", "--fit", "drag"), "--fit drag: unknown factor"),
        (("ten-cate-e4.csv", "--printed-mass", "5"), "--printed-mass 5: in kg"),
        (("ten-cate-e4.csv", "--scale-error", "0.5"), "'--scale-error': should be less than or equal to 0.2"),
    ],
)
def test_wrong_options_are_refused_in_one_line(refused, track, arguments, message):
    assert message in refused("calibrate", "C", *arguments)


def test_a_calibration_that_is_none_is_refused(refused, tmp_path):
    (tmp_path / "wrong.toml").write_text("[calibration]\ncross_drag = [1.2, 1.3, 1.4]\n", encoding="utf-8")
    line = refused("evolve", "--calibration", "wrong.toml", "--evaluations", 1)
    assert "wrong.toml:2" in line and "low <= value <= high" in line
    assert "is not a file" in refused("evolve", "--calibration", "absent.toml", "--evaluations", 1)


@pytest.mark.long
def test_drops_are_planned_with_a_page_and_a_study_for_each(done):
    plan = done("drop", WORD, "--drops", 2, "--tank", 0.6, 0.4, 0.4, "--out", "plan", "--json")
    assert len(plan["drops"]) == 2
    gains = [drop["gain_bits"] for drop in plan["drops"]]
    assert gains == sorted(gains, reverse=True) and gains[-1] > 0
    assert set(plan["expected"]) | set(plan["reasons"]) == FACTORS
    page = Path("plan/protocol.html").read_text(encoding="utf-8")
    for text in ("Weigh the print", "Place the camera", "Ruler", "150 mm from 0 to 150"):
        assert text in page
    assert "http://" not in page.replace("http://www.w3.org/2000/svg", "") and "https://" not in page
    for number, drop in enumerate(plan["drops"], start=1):
        study = tomllib.loads(Path(f"plan/drop-{number}.toml").read_text(encoding="utf-8"))
        assert study["release"]["pitch_deg"] == drop["pitch_deg"]
        assert 0 < drop["depth"] < 0.4 and study["release"]["position"][2] == -drop["depth"]
    done("simulate", WORD, "--scenario", "plan/drop-1.toml", "--out", "flight", "--json")


def test_a_tank_that_is_smaller_than_the_agent_is_refused(refused):
    assert "the tank must be larger" in refused("drop", WORD, "--tank", 0.01, 0.01, 0.01)
