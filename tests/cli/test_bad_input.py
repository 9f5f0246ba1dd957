"""Bad input gets one line that names where, what and the next step; exit code 2, and nothing half-written."""

import json
import sys
from pathlib import Path

import pytest

BASE = 'base = "paper"\n'
SEGMENT = BASE + "[[pipe.segments]]\nstart = [0, 0, 0]\nend = [9, 0, 0]\n"
OUT = ("--evaluations", 1, "--workers", 1, "--out", "run")


@pytest.mark.parametrize(
    ("args", "parts"),
    [
        (("--target", "TP11"), ["--target TP11", "did you mean 'TP1'?"]),
        (("--set", "nonsense"), ["--set nonsense", "expected key=value, such as flow.speed=0.8"]),
        (("--set", "fluid.density=-1"), ["--set", "fluid.density = -1", "greater than or equal to 0.1 kg/m3"]),
        (("--set", "fluid.flow_force=half"), ["fluid.flow_force = 'half'", "should be 'full' or 'paper'"]),
        (
            ("--set", "flow.kind=parabolic"),
            ["--set flow.kind=parabolic", "unknown kind", "known: developed, developing"],
        ),
        (("--set", "flow.exponent=7"), ["'exponent' in [flow] of kind 'developed'; known: ", "kind, roughness, speed"]),
        (("--set", "simulator.tolerance=abc"), ["simulator.tolerance = 'abc'", "should be a number"]),
        (("--set", "simulator.step_limit=1.5"), ["simulator.step_limit = 1.5", "should be a whole number"]),
        (("--set", "base=paper"), ["--set base=paper", "name that scenario in place of the study"]),
        (("--set", "targets.CON=[1,0,0]"), ["target name 'CON'", "choose another"]),
    ],
)
def test_of_evolve(refused, args, parts):
    line = refused("evolve", *OUT, *args)
    for part in parts:
        assert part in line


def test_options_of_a_strategy_are_refused_for_an_agent(refused, finished_run):
    line = refused("inspect", f"{finished_run[0]}:TP1", "--set", "strategy.elites=5")
    assert "--set strategy.elites=5: no plugin is selected in [strategy]" in line


def test_a_misspelt_command_and_a_misspelt_option_before_it(refused):
    assert "evolve" in refused("evolv")
    assert "--versio" in refused("--versio")


@pytest.mark.parametrize(
    ("text", "line", "parts"),
    [
        (BASE + "[flows]\nspeed = 1\n", 2, ["unknown key 'flows'", "did you mean 'flow'?"]),
        (BASE + "[flow]\nspee = 1\n", 3, ["'spee' in [flow]", "did you mean 'speed'?"]),
        (SEGMENT, 2, ["'radius' is missing in [[pipe.segments]]"]),
        (SEGMENT.replace("9", "0") + "radius = 1\n", 2, ["start and end", "same point"]),
        (BASE + '[run]\nformats = ["stl", "smf"]\n', 3, ["no exporter is named 'smf'"]),
        (BASE + "[fluid]\ndensity = nan\n", 3, ["fluid.density = nan", "finite"]),
        (BASE + "[targets]\nB = [1, 0, 0]\nA = [1, 0, 5]\n", 4, ["targets.A = [1.0, 0.0, 5.0]", "outside the pipe"]),
        (BASE + '[targets]\n"../x" = [1, 0, 0]\n', 3, ["'../x'", "names a folder"]),
        (BASE + f"[targets]\n{'x' * 300} = [1, 0, 0]\n", 3, ["longer than 100 bytes"]),
        (BASE + "[targets]\nA1 = [1, 0, 0]\na1 = [2, 0, 0]\n", 4, ["'A1' and 'a1' differ only in case"]),
        (BASE + "[targets]\n", None, ["has no [targets]", "leak = [4.0, 0.0, -0.9]"]),
        (BASE + "[release]\nposition = [0, 0, 3]\n", 3, ["release.position", "outside the pipe"]),
        (BASE + '[release]\nvelocity = "fast"\n', 3, ["release.velocity = 'fast'", "'current' or 'rest'"]),
        (BASE + "pipe = 3\n", 2, ["pipe = 3 is not a table"]),
        (BASE + "title = 2020-01-01\n", 2, ["title", "should be text in quotes"]),
        (BASE + '[simulator]\nuse = "exdyn"\n', 3, ["no simulator is named 'exdyn'", "'exudyn'?"]),
        ("title = 'bare'\n", None, ["no plugin is selected in [grammar]", 'base = "pipe-inspection"']),
        ('title = "x"\nbase = "pipe-inspect"\n', 2, ["study 'pipe-inspect'", "did you mean 'pipe-inspection'?"]),
        ('base = "gone.toml"\n', 1, ["study 'gone.toml'", "neither a file nor a built-in"]),
        ('base = "study.toml"\n', 1, ["'base' leads back to study.toml"]),
        ("a = " + "[" * 5000, None, ["is not valid TOML", "too deeply"]),
        (BASE + "[flow]\nspeed = 0,8\n", 3, ["is not valid TOML: speed = 0,8", "decimal point: write 0.8"]),
        ('base = "C:\\Users\\me\\base.toml"\n', 1, ["a backslash in double quotes", "write / in its place"]),
        ('base = "pipe-inspection\n[flow]\n', 1, ["a quote is missing"]),
        ('[flow]\nkind = "uniform', 2, ["a quote is missing"]),
        ("base = pipe-inspection\n", 1, ['a text is in quotes: write "pipe-inspection"']),
        ("base = “pipe-inspection”\n", 1, ["the quotes must be straight"]),
        (BASE + "[flow]\nspeed: 0.8\n", 3, ["have = between them"]),
        ('base = "C:\\temp\\base.toml"\n', 1, ["neither a file nor", "\\t for a tab: write / in its place"]),
    ],
)
def test_of_a_study_file(refused, tmp_path, text, line, parts):
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    message = refused("evolve", "study.toml", *OUT)
    assert message.startswith(f"error: study.toml:{line}: " if line else "error: study.toml: ")
    for part in parts:
        assert part in message


def test_the_line_is_that_of_the_file_which_holds_the_key(refused, tmp_path):
    (tmp_path / "lake.toml").write_text(BASE + "[fluid]\ndensty = 1000\n")
    (tmp_path / "study.toml").write_text('base = "lake.toml"\n')
    assert refused("evolve", "study.toml", *OUT).startswith("error: lake.toml:3: ")


def test_a_study_that_is_no_text_file(refused, tmp_path):
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "folder.toml").mkdir()
    assert "bytes.toml: is not a text file; save it as text in UTF-8" in refused("evolve", "bytes.toml", *OUT)
    assert "'folder.toml' is a directory" in refused("evolve", "folder.toml", *OUT)
    assert "'gone.toml' is neither a file nor" in refused("evolve", "gone.toml", *OUT)
    assert "did you mean 'pipe-inspection'?" in refused("evolve", "pipe-inspektion", *OUT)
    assert "study ''" in refused("evolve", "", *OUT)


@pytest.mark.parametrize("command", ["evolve", "sample", "export", "simulate"])
def test_an_out_that_cannot_be_a_directory(refused, tmp_path, command):
    (tmp_path / "file").write_text("mine")
    args = {
        "evolve": ("evolve", "paper", "--evaluations", 1),
        "sample": ("sample", "--count", 1),
        "export": ("export", "C", "--format", "scad"),
        "simulate": ("simulate", "C", "--simulator", "native"),
    }[command]
    for out in ("file", "file/below"):
        line = refused(*args, "--out", out)
        assert "file" in line
        assert "choose another --out" in line
    if sys.platform == "linux" and Path("/proc/version").exists():
        # Not even the superuser makes directories there.
        assert "/proc/agents: cannot create the directory" in refused(*args, "--out", "/proc/agents")
    assert (tmp_path / "file").read_text() == "mine"


def test_an_out_that_is_in_use(refused, run_copy, tmp_path):
    line = refused("evolve", "paper", "--evaluations", 1, "--out", "run")
    assert "already holds a run" in line
    assert line.endswith("driftform resume run")
    run_copy.rename(tmp_path / "my run")
    assert refused("evolve", "paper", "--out", "my run").endswith("driftform resume 'my run'")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    assert "mine is not empty; choose another --out" in refused("evolve", "paper", "--out", "mine")
    assert "mine is not an empty directory" in refused("sample", "--count", 1, "--out", "mine")


@pytest.mark.parametrize(
    ("agent", "parts"),
    [
        ("addB-tiltn-1-M-movB", ["symbol 5 'movB'", "did you mean 'moveB'?"]),
        ("addB-tiltn", ["number of symbols is 2", "multiple of five"]),
        ("C: addB | S: addB", ["rule"]),
        ("", ["empty", "addB-tiltn-1-M-moveB"]),
        ("gone.json", ["gone.json", "no such file"]),
        ("gone:TP1", ["gone: no such run directory"]),
        ("x" * 5000, ["xxx ...", "not a genome"]),
        ("a\0b", ["not a genome"]),
    ],
)
def test_of_an_agent(refused, agent, parts):
    line = refused("inspect", agent)
    for part in parts:
        assert part in line
    assert len(line) < 500


def test_a_run_without_its_target_and_other_places(refused, run_copy, tmp_path):
    (tmp_path / "empty").mkdir()
    assert "name one of its targets too, such as run:TP1" in refused("inspect", "run")
    assert "run has no target 'TP2'; did you mean" in refused("inspect", "run:TP2")
    assert "run has no target ''; known: TP1, TP7" in refused("inspect", "run:")
    assert "empty holds no run.db" in refused("inspect", "empty:TP1")
    assert "directory, and holds no run" in refused("inspect", "empty")
    assert "empty holds no run.db" in refused("resume", "empty")
    assert "gone: no such run directory" in refused("resume", "gone")
    assert "expected a run directory" in refused("resume", "run/run.db")


def change(key, value):
    *tables, last = key.split(".")

    def changed(document):
        for table in tables:
            document = document[table]
        document[last] = value

    return changed


@pytest.mark.parametrize(
    ("harm", "parts"),
    [
        (change("format", "other"), ['lacks "format": "driftform-agent"']),
        (change("version", 2), ["version 2", "reads version 1"]),
        (change("genome", 3), ['"genome" must hold "grammar"']),
        (change("genome.symbols", ["C", 1]), ['"genome" must hold']),
        (change("genome.grammar", "other"), ["grammar 'other'", "uses 'lsystem'"]),
        (change("environment", None), ['"environment" is missing']),
        (change("environment", {}), ["no plugin is selected in [grammar]"]),
        (change("environment.targets", {"../x": [1, 0, 0]}), ["'../x'", "names a folder"]),
        (change("environment.pilot", {}), ["unknown key 'pilot'"]),
    ],
)
def test_of_an_agent_file(refused, agent_document, tmp_path, harm, parts):
    harm(agent_document)
    (tmp_path / "agent.json").write_text(json.dumps(agent_document))
    for command in ("inspect", "simulate", "export"):
        line = refused(command, "agent.json")
        assert line.startswith("error: agent.json: ")
        for part in parts:
            assert part in line


@pytest.mark.parametrize(
    ("data", "line"),
    [
        *(
            (text.encode(), "is not an agent file")
            for text in ("", "{", "[]", "[" * 100_000, '{"a": ' + "9" * 5000 + "}")
        ),
        (b"\x80\x04\x95", "is not an agent file, which is JSON in UTF-8"),
        (b"\x00", "is not a text file"),
    ],
)
def test_an_agent_file_that_is_none(refused, tmp_path, data, line):
    (tmp_path / "agent.json").write_bytes(data)
    assert refused("inspect", "agent.json").startswith(f"error: agent.json: {line}")
