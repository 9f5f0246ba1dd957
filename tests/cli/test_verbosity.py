"""``--quiet`` and ``-v``, and the logger behind them."""

import logging

import pytest

EVOLVE = ("evolve", "--strategy", "random", "--evaluations", "4", "--target", "TP1", "--seed", "1", "--workers", "1")
SHORT = ("--robust", "0", "--simulator", "native", "--set", "flight.horizon=0.5")


def test_a_library_has_no_handler():
    import driftform.search.advance

    assert driftform.search.advance
    assert logging.getLogger("driftform").handlers == []


@pytest.mark.long
def test_quiet_shows_results_and_warnings_alone(call):
    result = call("--quiet", *EVOLVE, *SHORT)
    assert result.exit_code == 0, result.stderr
    assert "run:  runs/" in result.stdout
    assert [line for line in result.stderr.splitlines() if not line.startswith("warning: ")] == []


@pytest.mark.long
def test_verbose_logs_what_is_done_and_leaves_no_handler(call):
    shown = {flag: call(flag, *EVOLVE, *SHORT).stderr for flag in ("-v", "-vv")}
    for stderr in shown.values():
        assert "info: runs/pipe-inspection-" in stderr and ": search, 4 evaluations in all" in stderr
    assert "debug: " not in shown["-v"]
    assert "debug: wrote runs/" in shown["-vv"] and "debug: 4 of 4 evaluations" in shown["-vv"]
    assert logging.getLogger("driftform").handlers == []
