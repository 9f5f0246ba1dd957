"""What people read of a result is in the words of the fitness in use."""

import pytest

from driftform.builtin.fitness import ClosestApproach, OutletFitness
from driftform.interfaces import Fitness
from driftform.runs.wording import (
    describe_doubt,
    describe_result,
    describe_worth,
    list_cells,
    list_headings,
    name_verdict,
    summarise,
)
from driftform.types import Verdict
from driftform.util.options import Table


class Lightness(Fitness[Table]):
    """Score by the mass in grams: 0 g has 100 %, 50 g has 0 %."""

    name = "lightness"
    heading = "mass g"
    unit = "g"
    goal = "a mass of at most 10 g"

    def score(self, trajectory, scenario, agent):
        raise NotImplementedError

    def measure(self, fitness):
        return 50 - fitness / 2

    def judge(self, fitness):
        return Verdict.REACHED if self.measure(fitness) <= 10 else Verdict.MISSED


class Plain(Lightness):
    """A fitness without words of its own."""

    heading, unit, goal = Fitness.heading, Fitness.unit, Fitness.goal
    measure, judge = Fitness.measure, Fitness.judge


@pytest.mark.parametrize(
    ("kind", "headings", "cells", "summary"),
    [
        (
            ClosestApproach,
            ("fitness %", "error % of d_max"),
            ("90.000", "10.000"),
            "an error of at most 1 % of the farthest distance in the pipe; error % of d_max at worst 10.00 (B)",
        ),
        (Lightness, ("fitness %", "mass g"), ("90.000", "5.000"), "a mass of at most 10 g; mass g at worst 5.00 (B)"),
        (Plain, ("fitness %",), ("90.000",), "a fitness of at least 99 %; fitness % at worst 90.00 (B)"),
    ],
)
def test_each_fitness_speaks_in_its_own_unit_and_shows_itself_once(kind, headings, cells, summary):
    fitness = kind(Table())
    assert list_headings(fitness) == headings
    assert list_cells(fitness, {"fitness": 90.0}) == cells
    reached = 2 if kind is Lightness else 1
    assert summarise(fitness, {"A": {"fitness": 99.5}, "B": {"fitness": 90.0}}) == (
        f"{reached} of 2 targets are reached: {summary}"
    )
    assert summarise(fitness, {"A": {"fitness": 42.0}}).startswith("The target is not reached: ")
    assert describe_result(Lightness(Table()), {"fitness": 90.0}) == "5.00 g"


def promise(hit, p90):
    return {"hit": hit, "flights": 40, "failed": 0, "median": p90 / 2, "p90": p90}


def result_of(printed, weighed, baseline, p90=(0.073, 0.07, 0.5)):
    one, other, nothing = (promise(hit, miss) for hit, miss in zip((printed, weighed, baseline), p90, strict=True))
    return {"fitness": 99.9, "within": 0.4, "robust": {**one, "weighed": other, "baseline": nothing}}


def test_a_target_is_kept_from_nine_flights_of_ten():
    fitness = ClosestApproach(Table())
    assert name_verdict(fitness, result_of(0.9, 0.9, 0)) == "kept"
    assert name_verdict(fitness, result_of(0.875, 0.9, 0)) == "kept if weighed"
    assert name_verdict(fitness, result_of(0.875, 0.875, 1)) == "missed"
    assert name_verdict(fitness, {"fitness": 99.9}) == "reached"


def test_a_promise_is_said_with_the_number_of_flights():
    fitness, result = ClosestApproach(Table()), result_of(0.94, 0.96, 0)
    assert describe_result(fitness, result) == "hit by 94 % of 40 flights (9 of 10 within 73 mm)"
    headings, cells = list_headings(fitness, promised=True), list_cells(fitness, result, promised=True)
    assert len(headings) == len(cells)
    assert cells == ("400", "94", "73", "96", "70", "0", "500")


def test_a_summary_counts_who_keeps_the_targets():
    results = {"A": result_of(0.95, 0.95, 0.0), "B": result_of(0.5, 0.95, 0.95), "C": result_of(0.5, 0.5, 0.0)}
    found = summarise(ClosestApproach(Table()), results)
    assert found == ("2 of 3 targets are kept if the print is weighed, 1 as printed, 1 by the baseline")


def test_a_shape_that_is_hardly_better_than_nothing_is_said_to_matter_little():
    results = {"A": result_of(1, 1, 0, (0.3, 0.2, 0.5)), "B": result_of(1, 1, 1, (0.3, 0.28, 0.3))}
    fitness = ClosestApproach(Table())
    [found] = describe_worth(fitness, results)
    assert found.startswith("the shape matters little for B:")
    assert describe_worth(fitness, {"A": results["A"]}) == []


def test_a_baseline_that_is_better_than_what_the_search_found_is_named_with_its_genome():
    results = {"A": result_of(0, 0.4, 0.7, (0.3, 0.3, 0.2)), "B": result_of(1, 1, 1, (0.3, 0.28, 0.27))}
    results["A"]["robust"]["baseline"]["genome"] = "C @ 0.0011"
    better, alike = describe_worth(ClosestApproach(Table()), results)
    assert better.startswith("the baseline is better for A ('C @ 0.0011'): take it")
    assert alike.startswith("the shape matters little for B:")


def test_a_run_without_a_baseline_says_nothing_of_the_worth_of_a_shape():
    fitness, result = ClosestApproach(Table()), result_of(1, 1, 1)
    del result["robust"]["baseline"]
    assert describe_worth(fitness, {"A": result}) == []
    assert list_cells(fitness, result, promised=True)[-2:] == ("-", "-")
    assert summarise(fitness, {"A": result}).endswith("0 by the baseline")


def test_what_the_doubt_about_gusts_makes_of_the_misses_is_said_if_there_is_one():
    results = {name: result_of(1, 1, 0, (0.3, 0.2, 0.5)) for name in "ABC"}
    fitness = ClosestApproach(Table())
    assert describe_doubt(fitness, results) == ""
    for result, known in zip(results.values(), (0.19, 0.16, 0.2), strict=True):
        result["robust"]["weighed"]["p90_known_gusts"] = known
    assert describe_doubt(fitness, results).endswith(
        "5 % of the 90 % misses of weighed prints in the median, 20 % at most (B)"
    )
    assert describe_doubt(OutletFitness(Table()), results) == ""


def test_a_fitness_of_shares_is_compared_by_shares():
    alike = {"A": result_of(1, 0.88, 0.88, (0.3, 0.2, 0.5)), "B": result_of(1, 1, 0.85, (0.3, 0.3, 0.3))}
    [found] = describe_worth(OutletFitness(Table()), alike)
    assert found.startswith("the shape matters little for A: a plain body of the right weight does nearly as well")
