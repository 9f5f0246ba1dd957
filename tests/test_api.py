"""driftform as a notebook uses it."""

import copy
import json
import pickle
import re
import subprocess
import sys
import zipfile
from base64 import b64decode
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from typer.testing import CliRunner

import driftform as df
from driftform.cli.app import app
from driftform.errors import InputError
from driftform.runs.agent_file import StoredAgent
from driftform.study import Study
from driftform.types import Evaluation

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


def small(**run):
    return df.load_study("paper", targets=["TP3", "TP7"], run={"seed": 1, "evaluations": 20, **run})


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return df.evolve(small(), tmp_path_factory.mktemp("api") / "run", progress=False)


def pictures(html):
    found = re.findall(r"data:image/svg\+xml;base64,([A-Za-z0-9+/=]+)", html)
    return [ET.fromstring(b64decode(data)) for data in found]


def cells(html):
    """The rows of all tables of a piece of HTML, which must be well formed."""
    body = re.sub(r"<img [^>]*>", "", html)
    return [["".join(td.itertext()) for td in tr] for tr in ET.fromstring(f"<div>{body}</div>").iter("tr")]


def test_the_package_offers_what_it_names_and_nothing_else():
    assert {"open_agent", "evolve", "load_study", "open_run"} <= set(dir(df))
    assert all(getattr(df, name) is not None for name in df.__all__)
    with pytest.raises(AttributeError, match="evolv"):
        df.evolv  # noqa: B018


def test_evolve_leaves_the_run_that_the_command_leaves(run, tmp_path):
    words = ["--target", "TP3", "--target", "TP7", "--simulator", "native", "--evaluations", "20"]
    result = CliRunner().invoke(
        app, ["evolve", "paper", *words, "--seed", "1", "--workers", "1", "--out", str(tmp_path / "run")]
    )
    assert result.exit_code == 0, result.stderr
    for target in run:
        ours, theirs = (p / "best" / target / "agent.json" for p in (run.path, tmp_path / "run"))
        assert StoredAgent.read(ours).document() == StoredAgent.read(theirs).document()
    names = {str(p.relative_to(run.path)) for p in run.path.rglob("*") if p.is_file()}
    theirs_names = {str(p.relative_to(tmp_path / "run")) for p in (tmp_path / "run").rglob("*") if p.is_file()}
    assert {n for n in names if "run.db-" not in n} == {n for n in theirs_names if "run.db-" not in n}


def test_a_finished_run_is_returned_without_flying(run, monkeypatch):
    from driftform.pipeline import Pipeline

    def refuse(*_):
        raise AssertionError("flown again")

    monkeypatch.setattr(Pipeline, "evaluate", refuse)
    assert df.evolve(small(), run.path, progress=False).best() == run.best()


def test_an_interrupted_run_goes_on_to_the_same_end(run, tmp_path, monkeypatch):
    from driftform.pipeline import Pipeline

    evaluate = Pipeline.evaluate
    calls = 0

    def stop_at_the_third(*args, **kwargs):
        nonlocal calls
        calls += 1
        if calls == 3:
            raise KeyboardInterrupt
        return evaluate(*args, **kwargs)

    with monkeypatch.context() as patch:
        patch.setattr(Pipeline, "evaluate", stop_at_the_third)
        with pytest.raises(KeyboardInterrupt):
            df.evolve(small(), tmp_path / "run", progress=False)
    assert 0 < len(df.open_run(tmp_path / "run").evaluations()["genome"]) < 20
    assert df.evolve(small(), tmp_path / "run", progress=False).best() == run.best()


def test_a_function_is_called_with_what_the_strategy_is_told(tmp_path):
    told = []
    study = df.load_study("paper", run={"seed": 1, "evaluations": 7, "robust": 0})
    run = df.evolve(
        study, tmp_path / "run", progress=False, on_batch=lambda first, found: told.append((first, len(found)))
    )
    assert sum(count for _, count in told) == 7
    assert [first for first, _ in told] == [0, *np.cumsum([count for _, count in told])[:-1]]
    assert study.scenario.robustness.conditions == 0 and run["TP1"].result["p90"] is None


def test_values_are_equal_by_their_content_after_pickle_and_copy(run):
    best = run["TP3"]
    for value in (run.study, run.study.make_pipeline(), best, best.agent, best.simulate()):
        again = pickle.loads(pickle.dumps(value))
        assert again == value == copy.deepcopy(value) and hash(again) == hash(value)
    other = best.under("flow.speed=0.7")
    assert other != best and other.study != best.study and other.pipeline != best.pipeline
    assert other.agent == best.agent and best.agent != best.agent.body
    moved = replace(best.agent, body=replace(best.agent.body, outer=best.agent.body.outer + 1e-9))
    assert moved != best.agent


def test_values_show_themselves_in_one_line(run):
    flight = run["TP3"].simulate()
    found = Evaluation.failed(run["TP3"].stored.genome, 3, "it sank")
    for value in (flight.agent, flight.agent.coefficients, flight.trajectory, found):
        assert re.fullmatch(r"<\w+.{10,90}>", repr(value))


def test_progress_goes_to_stderr(tmp_path, capsys):
    df.evolve(small(evaluations=2), tmp_path / "run")
    out, err = capsys.readouterr()
    assert out == "" and "2/2 evaluations" in err


def test_python_is_warned_of_what_the_command_line_warns_of_before_the_first_flight(tmp_path):
    study = tmp_path / "aside.toml"
    study.write_text(
        'base = "pipe-inspection"\n[simulator]\nuse = "native"\n[robustness]\nconditions = 0\n[run]\nseed = 1\nevaluations = 1\n[targets]\nA = [4, 0.3, 0.2]\n'
    )
    with pytest.warns(UserWarning) as caught:
        df.evolve(df.load_study(str(study)), tmp_path / "run", progress=False)
    printed = json.loads(CliRunner().invoke(app, ["scenarios", "check", str(study), "--json"]).stdout)
    assert [str(warning.message) for warning in caught] == printed["warnings"]
    assert "release the agent with a yaw" in str(caught[0].message)
    # The line is that of the script, not one of the library.
    assert caught[0].filename == __file__


def test_what_cannot_be_written_is_warned_of_and_the_run_is_there(tmp_path):
    from driftform.errors import WorkFailedError

    class Broken:
        suffix = ".x"

        def write(self, *_):
            raise WorkFailedError("no such shape")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Study, "make_exporter", lambda *_: Broken())
        with pytest.warns(UserWarning, match=r"agent\.x: not written: no such shape"):
            run = df.evolve(small(evaluations=2), tmp_path / "run", progress=False)
    assert set(run.best()) == {"TP3", "TP7"}


@pytest.mark.long
def test_a_script_needs_no_guard_for_its_workers(run, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import driftform as df\n"
        "study = df.load_study('paper', targets=['TP3', 'TP7'], use={'simulator': 'native'},\n"
        "                      run={'seed': 1, 'evaluations': 20})\n"
        "print(df.evolve(study, 'run', workers=2, progress=False).best())\n"
        "print(__file__)\n"
    )
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.stderr == ""
    assert done.stdout.splitlines() == [str(run.best()), str(script)]


def test_a_run_is_a_mapping_of_targets(run):
    assert list(run) == ["TP3", "TP7"] and len(run) == 2
    assert "TP3" in run and "TP9" not in run and run.get("TP9") is None
    with pytest.raises(KeyError) as told:
        run["TP33"]
    assert isinstance(told.value, InputError)
    assert str(told.value).endswith("has no target 'TP33'; did you mean 'TP3'?")


def test_the_best_is_the_largest_fitness_of_the_table(run):
    columns = run.evaluations()
    assert {len(values) for values in columns.values()} == {20}
    for target, found in run.best().items():
        fitness = columns[f"fitness_{target}"]
        assert found["fitness"] == max(fitness) and found["evaluation"] == int(np.argmax(fitness))
        assert run[target].genome == columns["genome"][found["evaluation"]]


def test_an_agent_flies_again_as_in_its_run(run):
    best = run["TP7"]
    flight = best.simulate()
    assert flight.fitness["TP7"] == pytest.approx(best.result["fitness"], abs=1e-9)
    # Equation 25: fitness falls linearly to zero at the farthest distance in the pipe.
    d_max = best.scenario.pipe.farthest_distance(np.array(best.scenario.targets["TP7"]))
    assert flight.closest["TP7"] == pytest.approx(d_max * (1 - flight.fitness["TP7"] / 100), rel=1e-6)
    assert str(flight.end) in repr(flight)


def test_other_surroundings_add_up_and_leave_the_agent_as_it_is():
    agent = df.open_agent(WORD, scenario="paper")
    other = agent.under("flow.speed=0.8").under("fluid.density=1025")
    assert (other.scenario.flow.speed, other.scenario.fluid.density) == (0.8, 1025)
    assert (agent.scenario.flow.speed, other.result, other.genome) == (1.0, {}, agent.genome)
    gained = 1025 - agent.scenario.fluid.density
    lift = gained * agent.mass.volume * agent.scenario.fluid.gravity
    assert other.net_buoyancy == pytest.approx(agent.net_buoyancy + lift)


def test_a_written_agent_holds_the_surroundings_it_was_put_in(tmp_path):
    agent = df.open_agent(WORD, scenario="paper").under("fluid.density=1025")
    [path] = agent.export("3mf", tmp_path / "new" / "word.3mf")
    document = json.loads(zipfile.ZipFile(path).read("Metadata/agent.json"))
    assert document["environment"]["fluid"]["density"] == 1025


def test_the_sealed_hull_of_an_agent_simulated_as_a_kit_is_written_with_a_warning(tmp_path):
    agent = df.open_agent(WORD, scenario="pipe-inspection", use={"simulator": "native"})
    with pytest.warns(UserWarning, match=r"simulated as a kit, whose parts weigh \d+\.\d\d g; export design\.under"):
        [sealed] = agent.export("stl", tmp_path / "sealed.stl")
    assert sealed.exists()
    # The warning's advice: without a warning, as the tests turn those into errors.
    assert len(agent.under("exporter.stl.kit=true").export("stl", tmp_path / "kit.stl")) > 2
    agent.export("svg", tmp_path / "drawing.svg")


def test_facts_are_those_that_inspect_tells():
    agent = df.open_agent(WORD, scenario="paper")
    facts = agent.inspect()
    assert facts["mass"] == agent.mass.mass and facts["length"] == agent.length
    assert facts["net_buoyancy"] == pytest.approx(agent.net_buoyancy)
    assert facts["max_diameter"] == agent.max_diameter
    assert len(facts["modules"]) == 3 and "3 modules" in repr(agent)


def test_values_show_themselves_in_a_notebook(run):
    best = run["TP3"]
    [drawing] = pictures(best._repr_html_())
    assert drawing.tag.endswith("svg")
    assert ET.tostring(drawing) == ET.tostring(ET.fromstring(best._repr_svg_()))
    assert any(best.name in text for text in drawing.itertext())
    for html in (run._repr_html_(), best.simulate()._repr_html_()):
        assert len(pictures(html)) == 1
        assert [row[0] for row in cells(html)[1:]] == ["TP3", "TP7"]
    header, *rows = cells(run._repr_html_())
    assert header[0] == "target"
    for row in rows:
        assert float(row[2]) == pytest.approx(run.best()[row[0]]["fitness"], abs=1e-3)


def test_a_study_shows_its_plugins_and_targets_and_fits_a_line():
    study = small()
    rows = cells(study._repr_html_())
    assert ["simulator", "native"] in rows and ["TP3", "3", "0", "-0.7"] in rows
    assert "\n" not in repr(study) and len(repr(study)) < 120 and "seed 1" in repr(study)


def test_names_of_others_are_text_in_html():
    study = df.load_study("paper", ['title="<script>alert(1)</script>"'], run={"seed": 1})
    assert "<script>" not in study._repr_html_()


def test_a_neutral_sphere_is_an_agent_by_its_diameter():
    """Flights in changed water are those of the same sphere, which the port of the scenario has to let through."""
    design = df.open_agent("sphere:40mm")
    assert design.max_diameter == pytest.approx(0.04) and design.net_buoyancy == pytest.approx(0, abs=1e-6)
    assert design.under("fluid.density=1000").mass.mass == pytest.approx(design.mass.mass)
    for text in ("sphere:40m", "sphere:0.1mm", "sphere:9000mm"):
        with pytest.raises(InputError, match="a sphere is named by its diameter"):
            df.open_agent(text)
