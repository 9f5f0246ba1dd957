"""Plugins that misbehave: one line that names plugin, seam and deed; no traceback, no hang, no wrong result."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Call = Callable[..., Any]
Program = Callable[..., subprocess.CompletedProcess[str]]

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("fakes")]

STUDY = ("evolve", "paper", "--simulator", "fake", "--target", "TP1", "--evaluations", 4)
RUN = ("--seed", 1, "--workers", 1, "--out", "run")


def last_line(result: Any) -> str:
    assert isinstance(result.exception, SystemExit), result.exception
    assert "Traceback" not in result.stderr
    return str(result.stderr.splitlines()[-1])


@pytest.mark.parametrize(
    ("deed", "text"),
    [
        ("exit", "simulator 'fake' failed in simulate(): SystemExit: 0 (in <lambda>, line "),
        ("none", "simulator 'fake' returned a NoneType"),
        ("empty", "simulator 'fake' returned a flight without increasing times from simulate_batch()"),
        (
            "unended",
            "simulator 'fake' returned a flight that ended by nothing from simulate_batch(), expected an End",
        ),
        ("backward", "simulator 'fake' returned a flight without increasing times from simulate_batch()"),
        ("nan", "simulator 'fake' returned a flight that is not finite from simulate_batch()"),
        ("silent", "simulator 'fake' failed in simulate(): SilentError: no message (in _raise, line "),
        ("foreign", "simulator 'fake' failed in simulate(): KeyError: 'x' (in _raise, line "),
    ],
)
def test_a_simulator_that_misbehaves_fails_the_evaluation_by_name(call: Call, deed: str, text: str) -> None:
    text = text.replace("returned a NoneType", "returned nothing from simulate_batch()")
    result = call(*STUDY, "--set", f"simulator.deed='{deed}'", *RUN)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: all 4 evaluations failed, 4 of them like this: {text}")
    # The command that flies one agent says the same.
    result = call(
        "simulate", "C", "--simulator", "fake", "--set", f"simulator.deed='{deed}'", "--out", "flight"
    )
    assert result.exit_code in (1, 2)
    assert "simulator 'fake'" in last_line(result) or deed == "silent"


@pytest.mark.parametrize(
    ("deed", "text"),
    [
        ("exit", "strategy 'deed' failed in ask(): SystemExit: 0 (in <lambda>, line "),
        ("none", "strategy 'deed' returned nothing from ask(), expected 1 to 4 candidates"),
        ("empty", "strategy 'deed' returned 0 candidates from ask(), expected 1 to 4 candidates"),
        ("silent", "strategy 'deed' failed in ask(): SilentError: no message (in _raise, line "),
    ],
)
def test_a_strategy_that_misbehaves_stops_the_run_by_name_and_again_on_resume(
    call: Call, deed: str, text: str
) -> None:
    result = call(*STUDY, "--strategy", "deed", "--set", f"strategy.deed='{deed}'", *RUN)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: {text}")
    result = call("resume", "run", "--workers", 1)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: {text}")


@pytest.mark.parametrize(
    ("slip", "text"),
    [
        ("heading", "fitness 'wordy' has heading = None, expected text"),
        ("unit", "fitness 'wordy' has unit = 5, expected text"),
        ("goal", "fitness 'wordy' has goal = None, expected text"),
        ("share", "fitness 'wordy' has share = None, expected text"),
        ("measure", "fitness 'wordy' returned nan of 0 % from measure(), expected a finite number"),
        ("judge", "fitness 'wordy' returned a str from judge(), expected a Verdict"),
        ("describe", "fitness 'wordy' returned a float from describe(), expected a str"),
        ("raising", "fitness 'wordy' failed in measure(): KeyError: 'lost' (in <lambda>, line "),
    ],
)
def test_a_fitness_without_readable_words_is_refused_before_a_search(
    call: Call, slip: str, text: str, tmp_path: Path
) -> None:
    options = ("--set", "fitness.use=wordy", "--set", f"fitness.slip='{slip}'")
    for command in ((*STUDY, *options, *RUN), ("scenarios", "check", "paper", *options)):
        result = call(*command)
        assert result.exit_code == 1
        assert last_line(result).startswith(f"error: {text}")
    assert not (tmp_path / "run").exists()


def test_a_fitness_that_is_no_number_is_named(call: Call) -> None:
    result = call(*STUDY, "--set", "fitness.use=nonsense", *RUN)
    assert last_line(result) == (
        "error: all 4 evaluations failed, 4 of them like this: "
        "fitness 'nonsense' returned [nan] from score(), expected an array of one number from 0 to 100"
    )


@pytest.mark.parametrize(
    ("returns", "text"),
    [
        ("none", "nothing"),
        ("text", "a str"),
        ("single", "the single number 50.0"),
        ("complex", "complex numbers"),
        ("texts", "a ndarray"),
        ("ragged", "a list"),
        ("table", "an array of shape (1, 1)"),
    ],
)
def test_a_fitness_that_returns_something_else_is_named_wherever_it_scores(
    call: Call, returns: str, text: str
) -> None:
    text = f"fitness 'odd' returned {text} from score(), expected"
    odd = ("--set", "fitness.use=odd", "--set", f"fitness.returns='{returns}'")
    result = call(*STUDY, *odd, *RUN)
    assert result.exit_code == 1
    text += " an array of one number from 0 to 100"
    assert last_line(result) == f"error: all 4 evaluations failed, 4 of them like this: {text}"
    result = call("simulate", "C", "--simulator", "fake", "--scenario", "paper", *odd, "--out", "flight")
    assert result.exit_code == 1
    assert last_line(result) == f"error: {text.replace('an array of one number', '10 numbers')}"


@pytest.mark.parametrize(
    ("returns", "text"),
    [
        ("none", "None"),
        ("list", "['A', 'B']"),
        ("numbers", "Genome(grammar='odd', symbols=(0.5, 0.25))"),
        ("text", "Genome(grammar='odd', symbols='AB')"),
    ],
)
def test_a_grammar_that_makes_no_genomes_is_refused_before_one_is_stored(
    call: Call, returns: str, text: str
) -> None:
    odd = ("--set", "grammar.use=odd", "--set", f"grammar.returns='{returns}'")
    result = call(*STUDY, "--strategy", "random", *odd, *RUN)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: strategy 'random' asked for {text}, expected a Genome whose")
    assert last_line(result).endswith("random(), flip() and crossover() of the grammar")


def test_a_strategy_that_does_not_accept_a_study_leaves_no_directory(call: Call, tmp_path: Path) -> None:
    """What is corrected then begins in the same directory."""
    text = "error: strategy 'picky' searches grammar 'reals', not 'lsystem'"
    for command in ((*STUDY, *RUN), ("scenarios", "check", "paper")):
        result = call(*command, "--set", "strategy.use=picky")
        assert result.exit_code == 2
        assert last_line(result) == text
    assert not (tmp_path / "run").exists()
    assert call(*STUDY, *RUN).exit_code == 0


@pytest.mark.parametrize(
    ("deed", "text"),
    [
        ("exit", "exporter 'deed' failed in write(): SystemExit: 0 (in <lambda>, line "),
        ("none", "exporter 'deed' returned nothing from write(), expected the files that it wrote"),
        ("foreign", "exporter 'deed' failed in write(): KeyError: 'x' (in _raise, line "),
    ],
)
def test_an_exporter_that_misbehaves_is_named_and_the_other_files_are_kept(
    call: Call, deed: str, text: str, tmp_path: Path
) -> None:
    options = ("--set", "run.formats=['deed', 'scad']", "--set", f"exporter.deed.deed='{deed}'")
    result = call(*STUDY, *options, *RUN)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: run/best/TP1/agent.never: not written: {text}")
    assert (tmp_path / "run" / "best" / "TP1" / "agent.scad").is_file()
    result = call("export", "run:TP1", "--format", "deed", "--out", ".")
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: {text}")


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
@pytest.mark.parametrize(("deed", "text"), [("die", "exit code 3"), ("segfault", "SIGSEGV")])
def test_an_exporter_that_takes_its_process_with_it_costs_one_line_and_no_other_file(
    call: Call, deed: str, text: str, tmp_path: Path
) -> None:
    options = ("--set", "run.formats=['scad', 'deed']", "--set", f"exporter.deed.deed='{deed}'")
    result = call(*STUDY, *options, *RUN)
    assert result.exit_code == 1
    assert last_line(result) == (
        f"error: run/best/TP1: not all of scad,deed was written: its process died 2 times ({text}); "
        "write what is missing with: driftform export run:TP1 --format scad,deed"
    )
    best = tmp_path / "run" / "best" / "TP1"
    assert {"agent.json", "agent.scad", "section.svg", "trajectory.csv"} <= {
        path.name for path in best.iterdir()
    }
    assert not list((tmp_path / "run").rglob("*.part"))
    # The run is finished, and continuing it ends in the same line.
    assert last_line(call("resume", "run", "--workers", 1)) == last_line(result)


def test_what_plugins_print_does_not_reach_stdout_beside_a_json_document(
    run: Program, tmp_path: Path
) -> None:
    result = run(*STUDY, "--set", "simulator.deed='print'", *RUN, "--json", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["evaluations"] == 4
    assert result.stderr.count("mind the gap") == 4
    assert result.stderr.count("mind the other gap") == 4
