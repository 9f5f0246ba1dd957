"""What people read of a result is in the words of the fitness in use."""

from driftform.builtin.closest_approach import ClosestApproach
from driftform.interfaces import Fitness
from driftform.options import Table
from driftform.runs.wording import list_cells, list_headings, summarise
from driftform.types import Verdict


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


def test_the_closest_approach_speaks_of_errors_in_percent_of_d_max():
    fitness = ClosestApproach(Table())
    assert list_headings(fitness) == ("fitness %", "error % of d_max")
    assert list_cells(fitness, 97.5) == ("97.500", "2.500")
    assert summarise(fitness, {"A": 99.5, "B": 90.0}) == (
        "1 of 2 targets are reached: an error of at most 1 % of the farthest distance in the pipe; "
        "error % of d_max at worst 10.00 (B)"
    )


def test_another_fitness_speaks_in_its_own_unit():
    fitness = Lightness(Table())
    assert list_headings(fitness) == ("fitness %", "mass g")
    assert list_cells(fitness, 90) == ("90.000", "5.000")
    assert fitness.describe(90) == "5.00 g"
    assert summarise(fitness, {"A": 90.0}) == (
        "The target is reached: a mass of at most 10 g; mass g at worst 5.00 (A)"
    )


def test_a_fitness_without_words_shows_itself_once():
    fitness = Plain(Table())
    assert list_headings(fitness) == ("fitness %",)
    assert list_cells(fitness, 42) == ("42.000",)
    assert summarise(fitness, {"A": 42.0}).startswith("The target is not reached: a fitness of at least 99 %")
