"""Files that others made are data: whatever they hold runs no code, and writes nothing outside ``--out``."""

import ast
import json
import sqlite3
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import driftform
from driftform.util.files import safe_stem

EVIL = [
    "../../evil",
    "/absolute/evil",
    "..",
    "",
    ".hidden",
    "a/b",
    "a\\..\\b",
    "a\0b",
    "line\nfeed",
    "\x1b[2Jcleared",
    "n" * 400,
    "__import__('os').system('touch pwned')",
    "'; DROP TABLE evaluation; --",
    "${HOME}",
    "$(touch pwned)",
    "<script>alert(1)</script>",
]


def everything(folder):
    return set(folder.rglob("*"))


@pytest.mark.parametrize("name", EVIL)
def test_the_name_of_an_agent_leads_nowhere_else(call, agent_document, tmp_path, name):
    deep = tmp_path / "a" / "b" / "c"
    deep.mkdir(parents=True)
    agent_document["name"] = name
    (tmp_path / "agent.json").write_text(json.dumps(agent_document))
    before = everything(tmp_path)
    exported = call("export", "agent.json", "--format", "scad", "--out", deep, "--json")
    assert exported.exit_code == 0, exported.stderr
    [written] = [Path(file["path"]) for file in json.loads(exported.stdout)["files"]]
    assert written.resolve().parent == deep.resolve()
    assert everything(tmp_path) - before == {written}

    flown = call("simulate", "agent.json", "--set", "flight.horizon=0.1")
    assert flown.exit_code == 0, flown.stderr
    assert "\x1b" not in flown.stdout + flown.stderr
    [folder] = (tmp_path / "flights").iterdir()
    assert {p.name for p in folder.iterdir()} == {"trajectory.csv", "flight.svg"}
    assert everything(tmp_path) - before - everything(tmp_path / "flights") == {written, tmp_path / "flights"}
    assert "<script" not in (folder / "flight.svg").read_text()


@given(st.text())
def test_a_safe_stem_is_one_part_of_a_path_and_not_hidden(name):
    stem = safe_stem(name)
    assert stem
    assert Path(stem).name == stem
    assert stem.isprintable()
    assert not stem.startswith(".")
    assert not set(stem) & set('/\\:*?"<>|')
    assert len(stem.encode()) <= 240
    assert safe_stem(stem) == stem


@pytest.mark.parametrize("evil", EVIL)
@pytest.mark.parametrize("key", ["title", "use", "option", "table"])
def test_nasty_strings_in_a_study_are_only_strings(call, tmp_path, evil, key):
    lines = {
        "title": f"title = {json.dumps(evil)}",
        "use": f"[simulator]\nuse = {json.dumps(evil)}",
        "option": f"[simulator]\nintegrator = {json.dumps(evil)}",
        "table": f"[{json.dumps(evil)}]",
    }
    path = tmp_path / "study.toml"
    path.write_text(f'base = "paper"\n{lines[key]}\n')
    out = tmp_path / "out"
    result = call("sample", "--scenario", "study.toml", "--count", 1, "--out", "out")
    if key == "title":
        assert result.exit_code == 0, result.stderr
        assert everything(tmp_path) == {path, out, out / "agent-0001.json"}
        return
    assert isinstance(result.exception, SystemExit)
    assert result.exit_code == 2
    [line] = result.stderr.splitlines()
    assert line.isprintable()
    assert everything(tmp_path) == {path}


def test_statements_in_symbols_and_failures_stay_text(call, run_copy, rows):
    connection = sqlite3.connect(run_copy / "run.db")
    evil = "'; DROP TABLE evaluation; --"
    connection.execute("UPDATE evaluation SET symbols = ?, population = ?", (json.dumps([evil]), evil))
    connection.commit()
    connection.close()
    before = rows(run_copy)
    for args in (("resume", "run"), ("inspect", "run:TP1"), ("inspect", f"run:{evil}")):
        result = call(*args)
        assert isinstance(result.exception, SystemExit)
        assert result.exit_code == 2
    assert rows(run_copy) == before


def test_no_module_unpickles_or_evaluates():
    """A look at the source, for what the tests above may have missed."""
    forbidden = {"pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib"}
    package = Path(driftform.__path__[0])
    for path in package.rglob("*.py"):
        if path.is_relative_to(package / "testing"):
            continue  # Contract tests may pickle what they made themselves.
        if path == package / "util" / "foreign.py":
            continue  # Its answers may name nothing but arrays: tests/util/test_foreign.py.
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                assert not forbidden & {alias.name.split(".")[0] for alias in node.names}, path
            elif isinstance(node, ast.ImportFrom):
                assert (node.module or "").split(".")[0] not in forbidden, path
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in {"eval", "exec"}, f"{path}:{node.lineno}"
