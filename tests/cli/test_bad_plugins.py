"""Plugins that misbehave: one line that names plugin, seam and deed; no traceback, no hang, no wrong result."""

import json
import sys

import pytest

pytestmark = [pytest.mark.long, pytest.mark.usefixtures("fakes")]

STUDY = ("evolve", "paper", "--simulator", "fake", "--target", "TP1", "--evaluations", 4)
RUN = ("--seed", 1, "--workers", 1, "--out", "run")

FLIGHT, CHECK = ("simulate", "C", "--scenario", "paper", "--simulator", "fake"), ("scenarios", "check", "paper")


def last_line(result):
    assert isinstance(result.exception, SystemExit), result.exception
    assert "Traceback" not in result.stderr
    return str(result.stderr.splitlines()[-1])


def choose(seam, slip):
    """Options that select a plugin and what it does: the one that is named "slipping", or the fake simulator."""
    use = ("--set", f"{seam}.use=slipping", "--set", "strategy.use=random") if seam != "simulator" else ()
    return (*(use[:2] if seam == "strategy" else use), "--set", f"{seam}.{'slip' if use else 'deed'}='{slip}'")


@pytest.mark.parametrize(
    ("seam", "slip", "text"),
    [
        ("simulator", "exit", "'fake' failed in simulate(): SystemExit: 0 (in <lambda>, line "),
        ("simulator", "none", "'fake' returned nothing from simulate_batch()"),
        ("simulator", "backward", "'fake' returned a flight without increasing times from simulate_batch()"),
        ("simulator", "nan", "'fake' returned a flight that is not finite from simulate_batch()"),
        ("simulator", "surrogate", "'fake' failed in simulate(): ValueError: half of a letter: \\ud800 (in _raise"),
        ("simulator", "silent", "'fake' failed in simulate(): SilentError: no message (in _raise, line "),
        ("builder", "none", "returned nothing from build(), expected a Body"),
        ("builder", "words", "failed in build(): TypeError: Body.outer holds values of type <U1, expected real"),
        ("hydrodynamics", "shape", "failed in coefficients(): ValueError: Coefficients.added_mass has shape (3, 3)"),
        ("hydrodynamics", "negative", "returned an added mass that is not symmetric"),
        ("fitness", "nan", "returned [nan] from score(), expected an array of 1 number from 0 to 100, one for each"),
        ("fitness", "ragged", "returned [[1.0], [2.0, 3.0]] from score(), expected an"),
        ("fitness", "raising", "failed in score(): LinAlgError: Singular matrix (in <lambda>"),
    ],
)
def test_a_plugin_that_misbehaves_in_each_evaluation_is_named_by_a_run_and_by_one_flight(call, seam, slip, text):
    text = f"{seam} {text}" if seam == "simulator" else f"{seam} 'slipping' {text}"
    result = call(*STUDY, *choose(seam, slip), *RUN)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: all 4 evaluations failed, 4 of them like this: {text}")
    result = call(*FLIGHT, *choose(seam, slip), "--json")
    assert result.exit_code in (1, 2) and result.stdout == "" and len(result.stderr.splitlines()) == 1
    assert " ".join(text.split()[:2]) in last_line(result) or slip in ("shape", "silent")


@pytest.mark.parametrize(
    ("seam", "slip", "text"),
    [
        ("fitness", "heading", "has heading = None, expected text"),
        ("fitness", "measure", "returned nan of 0 % from measure(), expected a finite number"),
        ("fitness", "raising words", "failed in measure(): KeyError: 'lost' (in <lambda>, line "),
        ("grammar", "list", "returned a list from random(), expected a Genome of grammar 'slipping'"),
        ("grammar", "floats", "failed in random(): TypeError: Genome holds 0.5, a float, expected text, such as repr"),
        ("grammar", "crossover", "returned a Genome from crossover(), expected two genomes"),
        ("grammar", "unread", "cannot read what to_text() returned: no"),
        ("grammar", "express", "returned nothing from express(), expected a Morphology"),
        ("grammar", "flat", "returned nan m and 0.0 rad as length and tilt of a module from express(), expected"),
        ("strategy", "picky", "searches grammar 'reals', not 'lsystem'"),
    ],
)
def test_a_plugin_that_cannot_be_searched_with_is_refused_before_a_search_and_leaves_no_directory(
    call, seam, slip, text, tmp_path
):
    """What is corrected then begins in the same directory."""
    for command in ((*STUDY, *RUN), CHECK):
        result = call(*command, *choose(seam, slip))
        assert result.exit_code == (2 if slip == "picky" else 1)
        # The place of the mistake follows.
        assert last_line(result).startswith(f"error: {seam} 'slipping' {text}")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("slip", "text"),
    [
        ("exit", "failed in ask(): SystemExit: 0 (in <lambda>, line "),
        ("generator", "failed in ask(): GeneratorExit (in _raise, line "),
        ("none", "returned nothing from ask(), expected 1 to 4 candidates"),
        ("target", "returned a candidate for target 'Mars' from ask(), expected one of TP1, or an empty text"),
        ("parents", "returned a candidate of generation 0 with parents (99,) from ask(), expected evaluations"),
        ("threshold", "returned a candidate with threshold (1.0, 2.0) from ask(), expected None or 1 number"),
    ],
)
def test_a_strategy_that_misbehaves_stops_the_run_by_name_and_again_on_resume(call, slip, text):
    for command in ((*STUDY, *choose("strategy", slip), *RUN), ("resume", "run", "--workers", 1)):
        result = call(*command)
        assert result.exit_code == 1
        assert last_line(result).startswith(f"error: strategy 'slipping' {text}")


def test_candidates_may_hold_integers_of_numpy_and_are_read_back(call):
    result = call(*STUDY, *choose("strategy", "numpy"), *RUN)
    assert result.exit_code == 0, result.stderr
    assert call("resume", "run", "--evaluations", 5, "--workers", 1).exit_code == 0


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            ("check", "C", "--no-programs", "--set", "checker.slipping.slip='none'"),
            "checker 'slipping' returned nothing",
        ),
        (
            ("check", "C", "--no-programs", "--set", "checker.slipping.slip='state'"),
            "checker 'slipping' returned a Finding with state = 'fine' from check(), expected a State",
        ),
        (
            (*FLIGHT, "--renderer", "flip-book", "--set", "renderer.flip-book.lost=true", "--film", "film.txt"),
            "renderer 'flip-book' returned nothing from film(), expected a WrittenFile",
        ),
    ],
)
def test_a_plugin_that_misbehaves_in_one_command_is_named(call, words, text):
    result = call(*words)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: {text}")


@pytest.mark.parametrize(
    ("deed", "text"),
    [
        ("exit", "exporter 'deed' failed in write(): SystemExit: 0 (in <lambda>, line "),
        ("none", "exporter 'deed' returned nothing from write(), expected the files that it wrote"),
        ("absent", "exporter 'deed' returned a WrittenFile of 'nowhere.never' from write(), expected the path of"),
    ],
)
def test_an_exporter_that_misbehaves_is_named_and_the_other_files_are_kept(call, deed, text, tmp_path):
    options = ("--set", "run.formats=['deed', 'scad']", "--set", f"exporter.deed.deed='{deed}'")
    result = call(*STUDY, *options, *RUN)
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: run/best/TP1/agent.never: not written: {text}")
    assert (tmp_path / "run" / "best" / "TP1" / "agent.scad").is_file()
    result = call("export", "run:TP1", "--format", "deed", "--out", ".")
    assert result.exit_code == 1
    assert last_line(result).startswith(f"error: {text}")


@pytest.mark.parametrize(
    ("deed", "text"),
    [
        ("leave", "error: exporter 'deed' failed in write(): SystemExit: os._exit(0) (in <lambda>, line "),
        ("thread", "warning: a plugin left the thread 'idle', which ends with the command"),
    ],
)
def test_a_plugin_neither_ends_a_command_without_a_word_nor_keeps_it_from_its_end(run, deed, text, tmp_path):
    done = run("export", "C", "--format", "deed", "--set", f"exporter.deed.deed='{deed}'", cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith(text)


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
@pytest.mark.parametrize(("deed", "text"), [("die", "exit code 3"), ("segfault", "SIGSEGV")])
def test_an_exporter_that_takes_its_process_with_it_costs_one_line_and_no_other_file(call, deed, text, tmp_path):
    options = ("--set", "run.formats=['scad', 'deed']", "--set", f"exporter.deed.deed='{deed}'")
    result = call(*STUDY, *options, *RUN)
    assert result.exit_code == 1
    assert last_line(result) == (
        f"error: run/best/TP1: not all of scad,deed was written: its process died 5 times ({text}); "
        "write what is missing with: driftform export run:TP1 --format scad,deed"
    )
    best = tmp_path / "run" / "best" / "TP1"
    assert {"agent.json", "agent.scad", "section.svg", "trajectory.csv"} <= {path.name for path in best.iterdir()}
    assert not list((tmp_path / "run").rglob("*.part"))
    # The run is finished, and continuing it ends in the same line.
    assert last_line(call("resume", "run", "--workers", 1)) == last_line(result)


def test_what_plugins_print_does_not_reach_stdout_beside_a_json_document(run, tmp_path):
    result = run(*STUDY, "--set", "simulator.deed='print'", *RUN, "--json", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert json.loads(result.stdout)["evaluations"] == 4
    assert result.stderr.count("mind the gap") == 4
    assert result.stderr.count("mind the other gap") == 4
