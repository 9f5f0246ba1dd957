"""How study files, built-in scenarios and options of the command line make one document."""

import tomllib
import tracemalloc

import numpy as np
import pytest
import tomli_w
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from driftform.errors import InputError
from driftform.plugins.registry import registry
from driftform.study import Document, load_study
from driftform.study.sources import read_scenarios
from driftform.util.options import MAX_SEED

BASE = 'base = "pipe-inspection"\n'


@pytest.fixture
def write(tmp_path):
    def written(text, name="study.toml"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        return str(path)

    return written


@pytest.mark.parametrize(
    ("text", "settings", "path", "value"),
    [
        ("[flow]\nspeed = 0.5\n[fluid]\ngravity = 1.62\n", [], "fluid.gravity", 1.62),
        ("[fluid]\ngravity = 1.62\n", [], "fluid.density", 999.1),
        ("[flow]\nspeed = 0.5\n", ["flow.speed=0.75"], "flow.speed", 0.75),
        ("[flow]\nspeed = 0.5\n", ["flow.speed=0.75", "flow.speed = 2"], "flow.speed", 2.0),
        ("[targets]\nleak = [4.0, 0.0, -0.9]\n", [], "targets", {"leak": [4.0, 0.0, -0.9]}),
        ("[[pipe.segments]]\nstart = [0, 0, 0]\nend = [9, 0, 0]\nradius = 2.0\n", [], "pipe.segments.0.radius", 2.0),
        ("", ["pipe.segments.0.radius=0.8"], "pipe.segments.0.end", [9.0, 0.0, 0.0]),
        ("", ["pipe.segments.0.radius=0.8", "targets.TP1.2=-0.4"], "targets.TP1", [1.0, 0.0, -0.4]),
        *(
            ("", [f"robustness.score{text}"], "robustness.score", "worst")
            for text in ("=worst", " = 'worst'", '="worst"')
        ),
        ("", ["robustness={score='worst'}"], "robustness.score", "worst"),
    ],
)
def test_a_value_is_that_of_the_last_source_that_names_it(write, text, settings, path, value):
    found = load_study(write(BASE + text), settings).document
    for name in path.split("."):
        found = found[int(name) if name.isdigit() else name]
    assert found == value


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_file_may_come_from_any_editor(tmp_path, encoding):
    text = 'base = "pipe-inspection"\r\ntitle = "Größe"\r\n\r\n[flow]\r\nspeed = 0.8\r\n'
    (tmp_path / "study.toml").write_bytes(text.encode(encoding))
    study = load_study(str(tmp_path / "study.toml"))
    assert (study.document["title"], study.document["flow"]["speed"]) == ("Größe", 0.8)


def test_a_base_may_have_a_base_beside_its_file(write):
    write(BASE + "[flow]\nspeed = 0.5\n[fluid]\ndensity = 1000\n", "deep/river.toml")
    write('base = "river.toml"\n[flow]\nspeed = 0.25\n', "deep/creek.toml")
    study = load_study(write('base = "deep/creek.toml"\n'))
    assert (study.scenario.flow.speed, study.scenario.fluid.density) == (0.25, 1000.0)


def test_a_file_beside_the_study_comes_before_a_built_in_scenario_of_its_name(write):
    write(BASE.replace("pipe-inspection", "own.toml") + "[flow]\nspeed = 0.25\n", "pipe-inspection")
    write(read_scenarios()["pipe-inspection"], "own.toml")
    assert load_study(write(BASE)).scenario.flow.speed == 0.25


def test_a_file_of_velocities_lies_beside_the_study_that_names_it(write, tmp_path, monkeypatch):
    across = np.linspace(-1.2, 1.2, 9)
    rows = [f"{x},{y},{z},1,0,0" for x in np.arange(-0.3, 9.6, 0.3) for y in across for z in across]
    write("\n".join(["x,y,z,u,v,w", *rows]), "sub/water.csv")
    write(BASE + '[flow]\nkind = "grid"\nfile = "water.csv"\n', "sub/study.toml")
    write('base = "sub/study.toml"\n', "other.toml")
    monkeypatch.chdir(tmp_path)
    for name in ("sub/study.toml", "other.toml"):
        assert load_study(name).document["flow"]["file"] == "sub/water.csv"


def test_a_wrong_pipe_is_named_also_where_targets_are_places_in_it(write):
    parts = '[[pipe.parts]]\nname = "entry"\nangle_deg = 45\nlength = 3.0\n'
    place = '[targets]\nTP1 = {part = "entry", at = 1.0, clock = 12, off_wall = 0.05}\n'
    name = write(f"{BASE}[pipe]\nsegments = []\nradius = 0.15\n{parts}{place}")
    with pytest.raises(InputError) as raised:
        load_study(name)
    [line] = raised.value.args
    assert line.startswith(f"{name}:7: unknown key 'angle_deg' in [[pipe.parts]] of kind 'straight'")


def test_targets_set_on_the_command_line_are_added_or_moved():
    moved = load_study(settings=["targets.TP2=[2, 0, 0]", "targets.leak=[4, 0, -0.9]"]).scenario
    assert moved.target_names == (*(f"TP{n}" for n in range(1, 11)), "leak")
    assert moved.targets["TP2"] == (2.0, 0.0, 0.0)
    assert moved.targets["TP1"] == (1.0, 0.0, -0.5)
    assert load_study(settings=["targets={leak=[4, 0, 0]}"]).scenario.target_names == ("leak",)


def test_targets_are_kept_in_the_order_of_the_scenario():
    study = load_study(targets=["TP7", "TP1"])
    assert study.scenario.target_names == ("TP1", "TP7")
    assert study.evaluations == 100


def test_another_plugin_drops_the_options_of_the_one_before(write, fakes):
    base = write(BASE + "[simulator]\ntolerance = 1e-9\nmax_step = 0.01\n", "base.toml")
    overlay = write('base = "base.toml"\n[simulator]\nuse = "fake"\npause = 0.5\n')
    assert load_study(base).document["simulator"]["tolerance"] == 1e-9
    simulator = load_study(overlay).document["simulator"]
    assert simulator["use"] == "fake"
    assert simulator["pause"] == 0.5
    assert "tolerance" not in simulator
    assert load_study(base, use={"simulator": "fake"}).document["simulator"]["pause"] == 0.0
    assert load_study(base, ["simulator.use=fake"]).document["simulator"]["pause"] == 0.0


def test_the_same_plugin_named_again_keeps_its_options(write):
    write(BASE + "[simulator]\ntolerance = 1e-9\n", "base.toml")
    overlay = write('base = "base.toml"\n[simulator]\nuse = "native"\nmax_step = 0.01\n')
    for study in (load_study(overlay), load_study(overlay, use={"simulator": "native"})):
        assert study.document["simulator"]["tolerance"] == 1e-9
        assert study.document["simulator"]["max_step"] == 0.01


@pytest.mark.parametrize(("text", "value"), [(".6", 0.6), ("+.05", 0.05), ("2.", 2.0)])
def test_a_number_needs_no_digits_on_both_sides_of_its_point(text, value):
    assert load_study(settings=[f"flow.speed={text}"]).scenario.flow.speed == value


def test_without_a_seed_one_is_drawn_and_kept():
    seeds = {load_study().seed for _ in range(5)}
    assert len(seeds) == 5
    study = load_study()
    assert load_study(Document("again", study.document)).seed == study.seed


@given(
    speed=st.floats(0.01, 10),
    density=st.floats(1, 3e4),
    targets=st.dictionaries(
        st.text("abcXYZ019_", min_size=1, max_size=8).map(lambda s: f"t{s}".lower()),
        st.tuples(st.floats(0, 9), st.floats(-0.7, 0.7), st.floats(-0.7, 0.7)),
        min_size=1,
        max_size=4,
    ),
    velocity=st.sampled_from(["current", "rest", [0.5, 0.0, 0.0]]),
    seed=st.integers(0, MAX_SEED),
)
@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_resolved_study_is_the_same_study(write, speed, density, targets, velocity, seed):
    document = {
        "base": "pipe-inspection",
        "flow": {"speed": speed},
        "fluid": {"density": density},
        "release": {"velocity": velocity},
        "targets": {name: list(point) for name, point in targets.items()},
        "run": {"seed": min(seed, 2**63 - 1), "formats": ["stl", "scad"]},
    }
    study = load_study(write(tomli_w.dumps(document)))
    text = tomli_w.dumps(dict(study.document))
    again = load_study(write(text, "resolved.toml"))
    assert again.document == study.document == tomllib.loads(text)
    assert list(again.scenario.targets) == list(study.scenario.targets) == list(targets)
    assert (again.scenario, again.run) == (study.scenario, study.run)
    held = load_study(Document("held", study.document))
    assert held.document == study.document


def test_a_run_of_0_2_0_opens_with_the_tables_of_seams_that_it_had():
    study = load_study("paper", run={"seed": 1})
    former = {**study.document, "inspector": {}, "reporter": {}}
    assert load_study(Document("run.db", former)).document == study.document
    with pytest.raises(InputError, match="unknown key 'reporter'"):
        load_study(Document("run.db", {**former, "reporter": {"mine": {}}}))


def test_an_environment_flies_without_a_strategy():
    study = load_study(run={"seed": 1})
    environment = study.environment()
    assert "strategy" not in environment
    assert "run" not in environment
    held = load_study(Document("agent.json", environment))
    assert held.make_pipeline().simulator.name == "native"
    assert held.run.evaluations is None


def test_a_strategy_begins_at_the_same_random_numbers_each_time():
    study = load_study(run={"seed": 1})
    assert study.make_strategy().ask(10) == study.make_strategy().ask(10)
    assert study.make_strategy().ask(10) != load_study(run={"seed": 2}).make_strategy().ask(10)


def test_the_default_is_the_papers_pipe_with_the_effects_that_the_paper_neglects():
    paper, main = load_study("paper").scenario, load_study().scenario
    anyhow = main.release.model_copy(update={"port": 0.0})
    assert (main.pipe, main.targets, anyhow) == (paper.pipe, paper.targets, paper.release)
    assert 0 < main.release.port < 0.05
    assert (main.flow.kind, main.contact.friction > 0) == ("developed", True)
    assert main.robustness.conditions > 0 and paper.robustness.conditions == 0
    pipeline = load_study(run={"seed": 1}).make_pipeline()
    agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(1)))
    assert pipeline.hydrodynamics.name == "panels"
    assert agent.coefficients.drag is not None
    assert agent.body.core.mass == pytest.approx(0.0328, abs=5e-5)
    assert agent.body.fittings is not None


@pytest.mark.parametrize("item", ["1", "-1", "first"])
def test_an_item_that_a_list_does_not_have_is_refused(item):
    with pytest.raises(InputError, match=rf"pipe.segments has no item '{item}'; its items are 0 to 0"):
        load_study(settings=[f"pipe.segments.{item}.radius=0.8"])


def test_another_kind_of_flow_drops_what_only_the_former_has():
    settings = ["flow.kind=uniform", "flow.speed=0.7", "flow.acceleration=0.1"]
    resolved = Document("agent", load_study(settings=settings).document)
    flow = load_study(resolved, ["flow.kind=turbulent"]).document["flow"]
    assert flow["speed"] == 0.7
    assert flow["kind"] == "turbulent"
    assert "acceleration" not in flow
    back = load_study(Document("agent", {**resolved.data, "flow": flow}), ["flow.kind=uniform"])
    assert back.document["flow"] == {"kind": "uniform", "speed": 0.7, "acceleration": 0.0, "added": [0.0, 0.0, 0.0]}


@pytest.mark.parametrize("seam", ["hydrodynamics", "simulator", "strategy"])
def test_every_other_plugin_without_options_that_it_needs_can_be_chosen_for_a_resolved_study(seam):
    resolved = Document("agent", load_study("pipe-inspection").document)
    for row in registry().seam(seam):
        if row.cls is not None and not any(field.is_required() for field in row.cls.Options.model_fields.values()):
            assert load_study(resolved, use={seam: row.name}).document[seam]["use"] == row.name


def test_a_key_of_twenty_thousand_names_is_refused_at_once(write):
    key = ".".join(["a", '"b"'] * 10_000)
    for load in (lambda: load_study(write(f"{key} = 1\n")), lambda: load_study(settings=[f"{key}=1"])):
        tracemalloc.start()
        with pytest.raises(InputError, match="a key of more than 20 names"):
            load()
        assert tracemalloc.get_traced_memory()[1] < 50e6
        tracemalloc.stop()
