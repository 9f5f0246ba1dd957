"""What a shell completes: asked as Typer's scripts ask, by variables of the environment."""

import pytest


@pytest.fixture
def complete(tmp_path, monkeypatch, run):
    def ask(line):
        words = line.split(" ")
        monkeypatch.setenv("_DRIFTFORM_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", line)
        monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
        result = run(cwd=tmp_path)
        assert result.stderr == ""
        return result.stdout.split()

    return ask


@pytest.mark.long
def test_commands_scenarios_plugins_keys_and_runs_are_completed(complete, tmp_path):
    assert complete("driftform ca") == ["calibrate"], "commands of plugins too"
    assert complete("driftform evolve pi") == ["pipe-inspection"]
    assert {"evolution", "paper", "random"} <= set(complete("driftform evolve --strategy "))
    assert complete("driftform evolve --set flow.sp") == ["flow.speed="]
    assert complete("driftform evolve --set strategy.el") == ["strategy.elites="]
    assert "exporter.3mf.kit=" in complete("driftform evolve --set exporter.3mf.k")
    (tmp_path / "runs" / "first").mkdir(parents=True)
    (tmp_path / "runs" / "first" / "run.db").touch()
    (tmp_path / "runs" / "empty").mkdir()
    assert complete("driftform resume runs/f") == ["runs/first"]
    assert complete("driftform resume ru") == ["runs/", "runs/empty/", "runs/first"]
    assert complete("driftform evolve no-such-") == [], "the shell completes files"


@pytest.mark.parametrize(
    ("shell", "part"),
    [
        ("bash", "complete -o default -F _driftform_completion driftform"),
        ("zsh", "#compdef driftform"),
        ("fish", "complete --command driftform"),
    ],
)
def test_each_shell_has_a_script(shell, part, run, monkeypatch, tmp_path):
    monkeypatch.setenv("_DRIFTFORM_COMPLETE", f"source_{shell}")
    result = run(cwd=tmp_path)
    assert result.returncode == 0
    assert part in result.stdout
