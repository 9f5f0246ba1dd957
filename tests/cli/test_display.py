"""The table of a run, which fits any terminal."""

import io
import os
import re
import signal
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from processes import Clock, read_until, start_on_terminal
from rich.console import Console

from driftform.cli.display import BARS, PAGE_S, PLAIN_BARS, View, draw_sparkline, progress_line
from driftform.runs.status import RunStatus, Throughput
from driftform.runs.store import EvaluationSummary


def test_a_sparkline_is_logarithmic_and_blank_where_nothing_is_known():
    # Eight bars over seven decades: one for each.
    errors = [None, *(10.0**-n for n in range(8))]
    assert draw_sparkline(errors, 1e-7, 1) == " " + BARS[::-1]
    assert draw_sparkline([1.0, 0.0], 1e-7, 1) == "█▁"
    assert draw_sparkline([1.0, 1e-7], 1e-7, 1, PLAIN_BARS) == "#_"


def shown(view, width, height, encoding="utf-8"):
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = Console(file=file, width=width, height=height, force_terminal=True, color_system=None)
    console.print(view)
    file.seek(0)
    return file.read().splitlines()


FAILURE = "not converged: no tolerance brings two flights of this body nearer to each other than 37.2 mm anywhere"


def a_view(targets, clock=None, fits=True, evaluations=300):
    names = [f"TP{n}" for n in range(1, targets + 1)]
    names[-1] = "the-far-end-of-the-pipe-behind-the-second-valve"
    standing = RunStatus(names, 1000)
    for index in range(evaluations):
        scores = [100 - 60 / (1 + index / 10) for _ in names]
        missed = {"port": 0.001 * index, "kit": 0.0}
        failure = FAILURE if index % 17 == 0 else None
        standing.add(EvaluationSummary(index, index // 50, "", failure, scores, {"mass": index}, missed))
    pace = Throughput(0, clock or Clock())
    return View(standing, pace, ("running", "12/s, 58 s left", "elapsed 25 s"), "runs/pipe-1: Ctrl-C stops", fits)


@pytest.mark.parametrize("evaluations", [0, 300])
@pytest.mark.parametrize("targets", [1, 10, 40])
@pytest.mark.parametrize(("width", "height"), [(80, 24), (120, 30), (60, 12), (200, 60)])
def test_the_display_fits_the_terminal(targets, width, height, evaluations):
    lines = shown(a_view(targets, evaluations=evaluations), width, height)
    # One line is left, for the cursor.
    assert len(lines) < height
    assert max(map(len, lines)) <= width
    text = "\n".join(lines)
    assert f"{evaluations} of 1000 evaluations" in text
    assert "12/s, 58 s left" in text
    assert lines[-1] == "runs/pipe-1: Ctrl-C stops"


def test_the_display_says_the_commonest_failure_in_one_line():
    lines = shown(a_view(10), 80, 24)
    assert lines[-4].startswith("failed most often (18 of 18): not converged: no tolerance brings two")
    assert not any("failed most often" in line for line in shown(a_view(10, evaluations=0), 80, 24))


def test_the_display_says_what_was_measured_of_the_best_and_which_constraints_are_missed():
    assert shown(a_view(1), 80, 24)[-3] == "missed: port 299 times, by 0.001 m or more"
    assert shown(a_view(10), 80, 24)[-2] == "best of TP1: mass 299"


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 50), st.integers(56, 140), st.integers(10, 60))
def test_no_terminal_is_too_small_or_too_large(targets, width, height):
    lines = shown(a_view(targets, evaluations=40), width, height)
    assert len(lines) <= height
    assert max(map(len, lines)) <= width


@pytest.mark.parametrize("width", [80, 120])
def test_numbers_are_whole_and_the_curve_falls(width):
    lines = shown(a_view(3), width, 24)
    [row] = [line for line in lines if line.startswith("TP1 ")]
    cells = row.split()
    # The last sound evaluation is the best: 60 / (1 + 29.9) percent off.
    error = 60 / (1 + 299 / 10)
    assert cells[1:4] == [f"{100 - error:.3f}", f"{error:.3f}", "299"]
    assert cells[5] == "18"
    curve = cells[6]
    # As wide as the part of the budget that is spent.
    assert len(curve) >= 0.3 * width // 6
    assert curve[0] > curve[-1] == BARS[0]
    assert list(curve) == sorted(curve, reverse=True)
    heads = " ".join(lines[:2])
    assert all(word in heads for word in ("target", "evaluation", "mean %", "failed", "left to 100 %"))


def test_targets_that_find_no_room_take_turns():
    clock = Clock()
    view = a_view(40, clock)
    seen = set()
    for _ in range(4):
        lines = shown(view, 80, 24)
        seen |= {found[1] for text in lines if (found := re.match(r"(TP\d+|the-far-end\S*)", text))}
        assert any(re.search(r"targets \d+ to \d+ of 40", text) for text in lines)
        clock.now += PAGE_S
    assert len(seen) == 40


def test_printed_once_all_targets_are_there_with_their_whole_names():
    text = "\n".join(shown(a_view(40, fits=False), 120, 24))
    assert "the-far-end-of-the-pipe-behind-the-second-valve" in text
    assert all(f"TP{n} " in text for n in range(1, 40))


def test_where_the_terminal_knows_ascii_alone_the_display_is_ascii():
    text = "\n".join(shown(a_view(3), 80, 24, "ascii"))
    assert text.isascii()
    assert re.search(r"[#*+=:.-]{3}_", text)


def test_a_line_of_progress_stays_a_line_with_hundreds_of_targets():
    status = RunStatus(tuple(f"T{n}" for n in range(300)), 20)
    status.add(EvaluationSummary(0, 0, "", None, [50.0 + n / 10 for n in range(300)]))
    line = progress_line(status, Throughput(0))
    assert line == "1/20 evaluations: best of 300 targets: median 64.95, worst T0 50.00"


def test_names_of_targets_are_no_markup():
    standing = RunStatus(("[red]A[/red]",), 10)
    text = "\n".join(shown(View(standing, Throughput(0), (), ""), 80, 24))
    assert "[red]A[/red]" in text


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
def test_on_a_terminal_the_run_is_shown_live_and_ctrl_c_leaves_the_command_that_goes_on(fake_plugin, tmp_path):
    args = ("evolve", "paper", "--target", "TP1", "--seed", "1", "--simulator", "fake", "--evaluations", "5000")
    words = (*args, "--workers", "1", "--out", "run")
    process, ours = start_on_terminal(*words, width=90, cwd=tmp_path, PYTHONPATH=str(fake_plugin))
    # A part of what is drawn may be read before the rest of it is written.
    drawn = (r"[1-9]\d* of 5000 evaluations", "log scale", "run: Ctrl-C stops, 'driftform resume' continues")
    seen = read_until(ours, lambda text: all(re.search(part, text) for part in drawn))
    process.send_signal(signal.SIGINT)
    rest = read_until(ours, lambda text: bool(re.search("resume with: driftform resume run\\s", text)))
    os.close(ours)
    assert process.wait(timeout=600) == 130
    assert "Traceback" not in seen + rest
    # The table is not erased: the cursor does not go up again after it was last drawn.
    table = rest[rest.rindex("left to 100 %") :]
    assert "TP1" in table
    assert not re.search(r"\x1b\[\d*A", table)
    last = rest.rstrip().splitlines()[-1]
    assert re.search(r"stopped after \d+ of 5000 evaluations; resume with: driftform resume run", last)
