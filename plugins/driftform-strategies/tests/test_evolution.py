"""Evolution by one symbol at a time."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.interfaces import SearchSpace, Table
from driftform.testing import StrategyContract
from driftform.testing.letters import LENGTH, LetterGrammar
from driftform.types import End, Evaluation, Genome, Trajectory
from driftform_strategies.evolution import Change, EvolutionOptions, EvolutionStrategy, position_at, smallest_indices
from driftform_strategies.random import RandomOptions, RandomStrategy

GRAMMAR = LetterGrammar(Table())
WEIGHTS = np.random.default_rng(11).normal(size=(LENGTH, 3))
"""How much each letter at each place lifts a flight, m at its end."""


class TestEvolution(StrategyContract):
    def plugin(self, space):
        return EvolutionStrategy(EvolutionOptions(), space)


class TestEvolutionThatOnlyAims(StrategyContract):
    def plugin(self, space):
        return EvolutionStrategy(EvolutionOptions(explore=0, random=5, batch=7, elites=1), space)


class NoLetters(LetterGrammar):
    """A grammar of one genome, which is empty: nothing in it can change."""

    def random(self, rng):
        return Genome(self.name, ())

    def express(self, genome):
        return LetterGrammar.express(self, GRAMMAR.parse("a" * LENGTH))


class Choosy(LetterGrammar):
    """A grammar in which ``a`` may not stand at the first place of a genome that ends in ``c``."""

    def random(self, rng):
        return self.parse("b" + super().random(rng).symbols[1] * (LENGTH - 1))

    def express(self, genome):
        if genome.symbols[0] == "a" and genome.symbols[-1] == "c":
            raise ValueError("a first and c last")
        return super().express(genome)


def evolution(seed=0, targets=("T1",), grammar=GRAMMAR, **options):
    space = SearchSpace(grammar, targets, np.random.default_rng(seed))
    return EvolutionStrategy(EvolutionOptions(**options), space)


def lift(genome):
    """What the letters add up to."""
    return float(sum(WEIGHTS[place, "abc".index(letter)] for place, letter in enumerate(genome.symbols)))


def make_trajectory(height):
    t = np.linspace(0.0, 8.0, 81)
    position = np.column_stack([t, np.zeros_like(t), height * (t / 8) ** 2])
    return Trajectory(t, position, np.tile([1.0, 0, 0, 0], (81, 1)), np.zeros((81, 6)), End.OUTLET)


def flown(genome, heights=(0.0,)):
    """A flight that rises by the letters' lift, scored for targets at these heights of its end."""
    height = lift(genome)
    fitness = [max(0.0, 100 - 10 * abs(height - wanted)) for wanted in heights]
    return Evaluation(genome, np.array(fitness), make_trajectory(height))


def played(strategy, budget, heights=(0.0,), evaluate=flown):
    """Everything asked for, and its error for each target, (budget, targets)."""
    asked, errors = [], []
    while len(asked) < budget:
        candidates = strategy.ask(budget - len(asked))
        outcomes = [evaluate(c.genome, heights) for c in candidates]
        strategy.tell(len(asked), outcomes)
        asked += candidates
        errors += [100 - outcome.fitness for outcome in outcomes]
    return asked, np.array(errors)


def test_children_differ_from_their_parent_by_one_symbol():
    asked, _ = played(evolution(random=10), 200)
    children = [candidate for candidate in asked if candidate.parents]
    assert len(children) > 150
    for child in children:
        (parent,) = child.parents
        assert sum(x != y for x, y in zip(child.genome.symbols, asked[parent].genome.symbols, strict=True)) == 1


def test_it_begins_with_random_genomes_that_work_for_no_target():
    asked = evolution(random=12).ask(1000)
    assert [(c.parents, c.generation, c.target) for c in asked] == [((), 0, "")] * 12


def test_no_body_flies_twice():
    asked, _ = played(evolution(1), 400)
    assert max(Counter(GRAMMAR.express(c.genome) for c in asked).values()) == 1


def test_it_beats_random_search_where_changes_add_up():
    heights = (-3.0, 0.0, 2.5)
    names = ("low", "middle", "high")
    ours, others = [], []
    for seed in range(8):
        _, errors = played(evolution(seed, names), 150, heights)
        ours.append(errors.min(axis=0))
        space = SearchSpace(GRAMMAR, names, np.random.default_rng(seed))
        _, errors = played(RandomStrategy(RandomOptions(), space), 150, heights)
        others.append(errors.min(axis=0))
    assert (np.mean(ours, axis=0) < 0.5 * np.mean(others, axis=0)).all()


def test_aimed_children_stray_less_than_explored_ones():
    # What a change did to one genome it does to any here: a guess is as good as a flight.
    def strays(explore):
        """How far children end from where the nearest flight to the target does, m; the mean of many."""
        found = []
        for seed in range(20):
            strategy = evolution(seed, random=20, explore=1.0)
            asked, errors = played(strategy, 40)
            best = lift(asked[int(errors.argmin())].genome)
            strategy.options = EvolutionOptions(random=20, explore=explore)
            found += [abs(lift(c.genome) - best) for c in strategy.ask(1000) if c.parents]
        return float(np.mean(found))

    assert strays(0.0) < 0.5 * strays(1.0)


def test_doubt_prefers_changes_that_move_little():
    def moves(doubt):
        """How far the changes of guesses move a flight, m; the mean of many."""
        found = []
        for seed in range(5):
            strategy = evolution(seed, random=20, explore=1.0)
            asked, _ = played(strategy, 60)
            strategy.options = EvolutionOptions(random=20, explore=0.0, doubt=doubt)
            found += [abs(lift(c.genome) - lift(asked[c.parents[0]].genome)) for c in strategy.ask(20) if c.parents]
        return float(np.mean(found))

    assert moves(10.0) < 0.8 * moves(0.0)


def test_targets_with_a_larger_error_get_more_children():
    strategy = evolution(4, ("near", "far"), random=20, batch=1000, pressure=1.0)
    genomes = [c.genome for c in strategy.ask(20)]
    strategy.tell(0, [Evaluation(g, np.array([90.0, 70.0]), make_trajectory(lift(g))) for g in genomes])
    counts = Counter(c.target for c in strategy.ask(1000) if c.parents)
    total = counts["near"] + counts["far"]
    assert abs(counts["far"] - 0.75 * total) < 5 * np.sqrt(total * 0.75 * 0.25)


def test_targets_that_are_all_reached_still_get_children():
    strategy = evolution(5, ("one", "other"))
    genomes = [c.genome for c in strategy.ask(100)]
    strategy.tell(0, [Evaluation(g, np.array([100.0, 100.0]), make_trajectory(0.0)) for g in genomes])
    assert {c.target for c in strategy.ask(1000)} == {"one", "other"}


def test_a_failed_flight_is_no_parent():
    strategy = evolution(6, random=10)
    candidates = strategy.ask(10)
    outcomes = [Evaluation.failed(c.genome, 1, "it broke", make_trajectory(0.0)) for c in candidates]
    outcomes[7] = flown(candidates[7].genome)
    strategy.tell(0, outcomes)
    assert {c.parents for c in strategy.ask(100)} == {(7,)}


def test_flights_that_keep_their_path_to_themselves_are_searched_by_fitness_alone():
    def silent(genome, heights):
        return Evaluation(genome, flown(genome, heights).fitness)

    for seed in range(8):
        asked, errors = played(evolution(seed, random=30), 150, evaluate=silent)
        parents = [errors[candidate.parents[0]].min() for candidate in asked if candidate.parents]
        assert len(parents) > 60
        assert np.mean(parents) < np.quantile(errors[:30], 0.2)


def test_a_grammar_with_nothing_to_change_is_no_obstacle():
    strategy = evolution(8, grammar=NoLetters(Table()))
    for first in range(0, 60, 20):
        candidates = strategy.ask(20)
        assert 1 <= len(candidates) <= 20
        strategy.tell(first, [Evaluation(c.genome, np.array([50.0]), make_trajectory(0.0)) for c in candidates])


def test_genomes_that_a_grammar_does_not_take_are_never_asked_for():
    grammar = Choosy(Table())
    asked, _ = played(evolution(9, grammar=grammar, random=10), 200)
    for candidate in asked:
        grammar.express(candidate.genome)


def test_the_opposite_change_moves_a_path_the_opposite_way():
    strategy = evolution(10)
    played(strategy, 60)
    assert strategy._moved
    for change, (moved, size) in strategy._moved.items():
        np.testing.assert_array_equal(strategy._moved[change.undo()][0], -moved)
        assert size == pytest.approx(np.linalg.norm(moved))


def test_memory_is_bounded(monkeypatch):
    monkeypatch.setattr("driftform_strategies.evolution.MAX_HASHES", 100)
    monkeypatch.setattr("driftform_strategies.evolution.FAMILY_SIZE", 20)
    strategy = evolution(10)
    played(strategy, 600)
    assert len(strategy._known) <= 101
    assert all(len(elite.family) <= 20 for elites in strategy._elites for _, elite in elites)
    assert len(strategy._moved) <= LENGTH * 6, "two ways between any two of three letters, at each place"


@given(st.text("abc", min_size=LENGTH, max_size=LENGTH), st.integers(0, LENGTH - 1), st.sampled_from("abc"))
def test_a_change_is_undone_by_its_way_back(text, place, letter):
    symbols = tuple(text)
    change = Change(place, symbols[place], letter)
    changed = change.apply(symbols)
    assert changed[place] == letter
    assert change.undo().apply(changed) == symbols


def test_a_change_is_not_made_where_another_symbol_stands():
    symbols = tuple("abcabcabcabc")
    assert Change(0, "b", "c").apply(symbols) is None
    assert Change(LENGTH, "a", "b").apply(symbols) is None


@given(st.floats(0, 12))
def test_a_place_lies_between_the_samples_and_stays_at_the_end(time):
    x, y, z = position_at(make_trajectory(4.0), time)
    end = min(time, 8.0)
    assert (x, y) == (pytest.approx(end, abs=1e-12), 0.0)
    # A parabola is at most curvature * gap^2 / 8 above its chord.
    assert z == pytest.approx(4.0 * (end / 8) ** 2, abs=2 * 4.0 / 64 * 0.1**2 / 8 + 1e-12)


@given(st.lists(st.floats(-5, 5), max_size=30, unique=True), st.integers(1, 40))
def test_the_least_values_are_those_that_sorting_puts_first(values, count):
    found = smallest_indices(np.array(values), count).tolist()
    assert [values[i] for i in found] == sorted(values)[:count]
