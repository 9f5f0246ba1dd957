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
        ("backward", "simulator 'fake' returned a flight without increasing times from simulate_batch()"),
        ("nan", "simulator 'fake' returned a flight that is not finite from simulate_batch()"),
        ("surrogate", "simulator 'fake' failed in simulate(): ValueError: half of a letter: \\ud800 (in _raise"),
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
    result = call("simulate", "C", "--simulator", "fake", "--set", f"simulator.deed='{deed}'", "--out", "flight")
    assert result.exit_code in (1, 2)
    assert "simulator 'fake'" in last_line(result) or deed == "silent"


@pytest.mark.parametrize(
    ("deed", "text"),
    [
        ("exit", "strategy 'deed' failed in ask(): SystemExit: 0 (in <lambda>, line "),
        ("none", "strategy 'deed' returned nothing from ask(), expected 1 to 4 candidates"),
    ],
)
def test_a_strategy_that_misbehaves_stops_the_run_by_name_and_again_on_resume(call: Call, deed: str, text: str) -> None:
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
        ("measure", "fitness 'wordy' returned nan of 0 % from measure(), expected a finite number"),
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


@pytest.mark.parametrize(
    ("slip", "text"),
    [
        ("list", "returned a list from random(), expected a Genome of grammar 'slipping'"),
        ("floats", "failed in random(): TypeError: Genome holds 0.5, a float, expected text, such as repr"),
        ("crossover", "returned a Genome from crossover(), expected two genomes"),
        ("unread", "cannot read what to_text() returned: no"),
        ("express", "returned nothing from express(), expected a Morphology"),
        ("flat", "returned nan m and 0.0 rad as length and tilt of a module from express(), expected"),
    ],
)
def test_a_grammar_that_misbehaves_is_refused_by_name_before_a_search(
    call: Call, slip: str, text: str, tmp_path: Path
) -> None:
    options = ("--set", "grammar.use=slipping", "--set", f"grammar.slip='{slip}'")
    for command in ((*STUDY, "--strategy", "random", *RUN), ("scenarios", "check", "paper")):
        result = call(*command, *options)
        assert result.exit_code == 1
        # The place of the mistake follows.
        assert last_line(result).startswith(f"error: grammar 'slipping' {text}")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("seam", "slip", "text"),
    [
        ("builder", "none", "builder 'slipping' returned nothing from build(), expected a Body"),
        (
            "builder",
            "words",
            "builder 'slipping' failed in build(): TypeError: Body.outer holds values of type <U1, expected real",
        ),
        (
            "hydrodynamics",
            "shape",
            "hydrodynamics 'slipping' failed in coefficients(): ValueError: Coefficients.added_mass has shape (3, 3)",
        ),
        ("hydrodynamics", "negative", "hydrodynamics 'slipping' returned an added mass that is not symmetric"),
        ("fitness", "texts", "fitness 'slipping' returned ['50'] from score(), expected an array of 1 number"),
        ("fitness", "scalar", "fitness 'slipping' returned 50.0 from score(), expected an array of 1 number"),
        ("fitness", "ragged", "fitness 'slipping' returned [[1.0], [2.0, 3.0]] from score(), expected an"),
        ("fitness", "raising", "fitness 'slipping' failed in score(): LinAlgError: Singular matrix (in <lambda>"),
    ],
)
def test_what_cannot_be_a_value_of_a_seam_is_named_by_a_run_and_by_one_flight(
    call: Call, seam: str, slip: str, text: str
) -> None:
    options = ("--set", f"{seam}.use=slipping", "--set", f"{seam}.slip='{slip}'")
    result = call(*STUDY, *options, *RUN)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: all 4 evaluations failed, 4 of them like this: {text}")
    result = call("simulate", "C", "--scenario", "paper", "--simulator", "fake", *options, "--json")
    assert result.exit_code in (1, 2)
    assert result.stdout == ""
    assert f"{seam} 'slipping'" in last_line(result) or "Coefficients.added_mass has shape" in last_line(result)
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("slip", "text"),
    [
        ("word", "returned a str from ask(), expected a Candidate"),
        ("target", "returned a candidate for target 'Mars' from ask(), expected one of TP1, or an empty text"),
        ("parents", "returned a candidate of generation 0 with parents (99,) from ask(), expected evaluations"),
        ("threshold", "returned a candidate with threshold (1.0, 2.0) from ask(), expected None or 1 number"),
    ],
)
def test_candidates_that_do_not_fit_into_the_run_are_refused(call: Call, slip: str, text: str) -> None:
    result = call(*STUDY, "--set", "strategy.use=slipping", "--set", f"strategy.slip='{slip}'", *RUN)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: strategy 'slipping' {text}")


def test_candidates_may_hold_integers_of_numpy_and_are_read_back(call: Call) -> None:
    result = call(*STUDY, "--set", "strategy.use=slipping", "--set", "strategy.slip='numpy'", *RUN)
    assert result.exit_code == 0, result.stderr
    assert call("resume", "run", "--evaluations", 5, "--workers", 1).exit_code == 0


@pytest.mark.parametrize(
    ("slip", "text"),
    [
        ("none", "returned nothing from check(), expected a list of Findings"),
        ("state", "returned a Finding with state = 'fine' from check(), expected a State"),
    ],
)
def test_a_checker_that_misbehaves_is_named(call: Call, slip: str, text: str) -> None:
    result = call("check", "C", "--no-programs", "--set", f"checker.slipping.slip='{slip}'")
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: checker 'slipping' {text}")


def test_a_renderer_that_says_nothing_of_its_film_is_named(call: Call) -> None:
    options = ("--simulator", "fake", "--renderer", "flip-book", "--set", "renderer.flip-book.lost=true")
    result = call("simulate", "C", *options, "--film", "film.txt")
    assert result.exit_code == 1
    assert last_line(result) == "error: renderer 'flip-book' returned nothing from film(), expected a WrittenFile"


def test_a_fitness_that_is_no_number_is_named(call: Call) -> None:
    result = call(*STUDY, "--set", "fitness.use=nonsense", *RUN)
    assert last_line(result) == (
        "error: all 4 evaluations failed, 4 of them like this: "
        "fitness 'nonsense' returned [nan] from score(), expected an array of 1 number from 0 to 100, one for each target"
    )


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
        ("absent", "exporter 'deed' returned a WrittenFile of 'nowhere.never' from write(), expected the path of"),
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
    assert {"agent.json", "agent.scad", "section.svg", "trajectory.csv"} <= {path.name for path in best.iterdir()}
    assert not list((tmp_path / "run").rglob("*.part"))
    # The run is finished, and continuing it ends in the same line.
    assert last_line(call("resume", "run", "--workers", 1)) == last_line(result)


def test_what_plugins_print_does_not_reach_stdout_beside_a_json_document(run: Program, tmp_path: Path) -> None:
    result = run(*STUDY, "--set", "simulator.deed='print'", *RUN, "--json", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["evaluations"] == 4
    assert result.stderr.count("mind the gap") == 4
    assert result.stderr.count("mind the other gap") == 4
