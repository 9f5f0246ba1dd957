"""The state of a run, counted in any order, and how fast it advances."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from processes import Clock

from driftform.cli.display import format_throughput, progress_line
from driftform.runs.status import PARTS, RunStatus, Throughput
from driftform.runs.store import EvaluationSummary

fitness = st.floats(0, 100)


@st.composite
def runs(draw):
    """Evaluations of a run for the targets A and B, in order: index, generation, population, failure, fitness."""
    size = draw(st.integers(1, 6))
    count = draw(st.integers(1, 40))
    return [
        (
            index,
            index // size,
            draw(st.sampled_from(["A", "B", ""])),
            draw(st.sampled_from([None, "it sank"])),
            [draw(fitness), draw(fitness)],
        )
        for index in range(count)
    ]


def standing_of(evaluations):
    standing = RunStatus(("A", "B"), 100)
    for evaluation in evaluations:
        standing.add(EvaluationSummary(*evaluation))
    return standing


def summary(standing):
    return [
        (t.best, t.index, t.generation, t.failed, t.mean and pytest.approx(t.mean), t.list_errors())
        for t in standing.targets.values()
    ]


@given(runs(), st.randoms(use_true_random=False))
def test_the_order_in_which_evaluations_come_does_not_matter(run, random):
    shuffled = list(run)
    random.shuffle(shuffled)
    assert summary(standing_of(shuffled)) == summary(standing_of(run))


@given(runs())
def test_a_standing_is_what_a_look_at_all_evaluations_finds(run):
    standing = standing_of(run)
    assert standing.done == len(run)
    assert standing.failed == sum(failure is not None for *_, failure, _ in run)
    for place, (name, target) in enumerate(standing.targets.items()):
        sound = [(row[-1][place], -row[0]) for row in run if not row[3]]
        assert (target.best, -target.index) == max(sound, default=(0.0, 1))
        own = [row for row in run if row[2] in (name, "")]
        assert target.failed == sum(row[3] is not None for row in own)
        assert target.generation == max((row[1] for row in own), default=-1)
        newest = [row[-1][place] for row in own if row[1] == target.generation and not row[3]]
        assert target.mean == (pytest.approx(sum(newest) / len(newest)) if newest else None)


@given(runs())
def test_a_curve_is_the_best_error_so_far_at_the_end_of_each_part_of_the_budget(run):
    for place, target in enumerate(standing_of(run).targets.values()):
        errors = [(row[0], 100 - row[-1][place]) for row in run if not row[3]]
        begun = max((PARTS * index // 100 + 1 for index, _ in errors), default=0)
        expected = [min((e for i, e in errors if PARTS * i // 100 <= part), default=None) for part in range(begun)]
        assert target.list_errors() == expected


def test_the_time_left_is_that_of_the_recent_rate_also_where_evaluations_are_slow():
    clock = Clock()
    pace = Throughput(0, clock)
    done = 0
    for seconds in (1.0,) * 200 + (20.0,) * 20:
        clock.now += seconds
        done += 1
        pace.mark(done)
    assert pace.measure(done) == pytest.approx(1 / 20)


def test_evaluations_that_come_together_at_first_are_not_a_rate():
    clock = Clock()
    pace = Throughput(0, clock)
    clock.now += 40
    for done in range(1, 21):
        clock.now += 1e-3
        pace.mark(done)
    assert pace.measure(20) is None
    for done in range(21, 41):
        clock.now += 1
        pace.mark(done)
    assert pace.measure(40) == pytest.approx(1)


def test_what_was_stored_before_says_nothing_of_the_pace():
    clock = Clock()
    pace = Throughput(500, clock)
    clock.now += 2
    for done in (100, 500):
        pace.mark(done)
        assert pace.measure(done) is None
    clock.now += 2
    pace.mark(510)
    clock.now += 4
    pace.mark(520)
    assert pace.measure(520) == pytest.approx(2.5)


def test_a_rate_needs_more_than_a_few_evaluations_after_the_first():
    clock = Clock()
    pace = Throughput(0, clock)
    for done in range(1, 8):
        clock.now += 60
        pace.mark(done)
        expected = None if done < 6 else pytest.approx(1 / 60)
        assert pace.measure(done) == expected


def test_time_left_is_that_of_the_present_pace():
    clock = Clock()
    standing, pace = RunStatus(("A",), 1000), Throughput(0, clock)
    assert format_throughput(standing, pace) == ""
    for index in range(400):
        standing.add(EvaluationSummary(index, 0, "", None, [50.0]))
    clock.now += 40  # The equations of motion are compiled.
    pace.mark(100)
    assert format_throughput(standing, pace) == ""
    clock.now += 30
    pace.mark(400)
    assert format_throughput(standing, pace) == "10/s, 1 min 00 s left"
    assert progress_line(standing, pace) == "400/1000 evaluations, 10/s, 1 min 00 s left: A 50.00"
