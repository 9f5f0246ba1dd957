"""Names that a terminal, an encoding or a file system finds odd: shown with escapes, and no reason to stop."""

import os
import sys

import pytest

pytestmark = pytest.mark.long


def test_a_title_cannot_steer_the_terminal(call, tmp_path):
    (tmp_path / "study.toml").write_text('base = "paper"\ntitle = "\\u001b[2Jcleared"\n')
    result = call("scenarios", "check", "study.toml")
    assert result.exit_code == 0, result.stderr
    assert "\x1b" not in result.stdout
    assert "\\x1b[2Jcleared" in result.stdout


def test_letters_that_the_encoding_of_the_terminal_lacks_are_shown_as_escapes(run, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    (tmp_path / "study.toml").write_text('base = "paper"\ntitle = "\u03a9"\n', encoding="utf-8")
    result = run("scenarios", "check", "study.toml", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[0].endswith(": \\u03a9")


@pytest.mark.skipif(sys.platform != "linux", reason="other file systems want names that are text")
def test_a_run_directory_may_have_a_name_of_any_bytes(run, tmp_path):
    name = os.fsdecode(b"r\xff\xe9")
    study = ("paper", "--simulator", "fake", "--target", "TP1", "--evaluations", 4, "--seed", 1)
    for args in (
        ("evolve", *study, "--workers", 1, "--out", name),
        ("resume", name, "--workers", 1, "--evaluations", 6, "--json"),
        ("watch", name, "--once"),
        ("inspect", f"{name}:TP1"),
        ("report", name),
        ("export-data", name),
        ("export", f"{name}:TP1", "--format", "scad", "--out", name),
    ):
        result = run(*args, cwd=tmp_path)
        assert result.returncode == 0, (args, result.stderr)
        assert "Traceback" not in result.stderr
    assert (tmp_path / name / "report.html").is_file()
