"""Measures of a flight, the archive, and what it breeds."""

import sys
from collections import Counter

import numpy as np
import pytest

import driftform_ribs
from driftform.errors import InputError
from driftform.interfaces import SearchSpace, Table
from driftform.plugins.registry import registry
from driftform.runs.coverage import PipeGrid
from driftform.testing.letters import LetterGrammar
from driftform.types import End, Evaluation, Genome, Trajectory
from driftform.water import Pipe, Scenario, Segment
from driftform_ribs.strategy import RibsOptions, RibsStrategy, as_objects, make_archive, station_heights

GRAMMAR = LetterGrammar(Table())
SCENARIO = Scenario(pipe=Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0),)))
CELLS = PipeGrid.of_scenario(SCENARIO)


def flight(position):
    position = np.array(position, dtype=float)
    k = len(position)
    turn = np.tile([1.0, 0, 0, 0], (k, 1))
    return Trajectory(np.arange(float(k)), position, turn, np.zeros((k, 6)), End.OUTLET)


def rising(rise):
    x = np.linspace(0.0, 9.0, 31)
    return flight(np.column_stack([x, 0 * x, rise * x / 9]))


def strategy(seed=0, **options):
    space = SearchSpace(GRAMMAR, ("T",), np.random.default_rng(seed), SCENARIO)
    return RibsStrategy(RibsOptions(archive="grid", **options), space)


def test_heights_are_those_where_a_flight_first_passes_each_station():
    there_and_back = flight([[0, 0, 0], [4, 0, 0.4], [2, 0, -0.8], [9, 0, 0.6]])
    np.testing.assert_allclose(station_heights(CELLS, there_and_back, np.array([1.0, 3.0, 9.0])), [0.1, 0.3, 0.6])


def test_where_a_flight_does_not_come_to_a_station_the_height_of_its_end_counts():
    short = flight([[0, 0, 0], [4, 0, 0.4], [5, 0, -0.3]])
    np.testing.assert_allclose(station_heights(CELLS, short, np.array([2.0, 6.0, 9.0])), [0.2, -0.3, -0.3])


def test_a_flight_that_is_released_behind_a_station_has_the_height_of_its_release_there():
    np.testing.assert_allclose(station_heights(CELLS, flight([[3, 0, 0.2], [9, 0, 0.8]]), np.array([1.0])), [0.2])


def test_any_measures_are_the_axes_of_the_archive():
    made = strategy(random=4, batch=4, measures={"mass": (0.0, 1.0), "length": (0.1, 0.3), "height_0.5": (-1.0, 1.0)})
    found = [
        Evaluation(one.genome, np.array([50.0]), rising(0.1), measures={"mass": mass, "length": 0.2})
        for one, mass in zip(made.ask(4), (0.1, 0.4, 0.4001, 0.9), strict=True)
    ]
    made.tell(0, found)
    places = made._archive.data("measures", return_type="tuple")[0]
    assert places[:, [0, 2]] == pytest.approx(np.array([[0.1, 0.05], [0.4, 0.05], [0.9, 0.05]]))
    with pytest.raises(
        InputError, match=r"strategy\.measures has 'weight', which no evaluation has; these have mass, length"
    ):
        other = strategy(random=4, batch=4, measures={"weight": (0.0, 1.0)})
        other.ask(4)
        other.tell(0, found)


def test_a_grid_has_as_many_cells_in_each_measure_as_the_number_of_cells_allows():
    for cells, stations, dims in ((1000, 3, [10] * 3), (999, 3, [9] * 3), (400, 2, [20, 20]), (2, 6, [2] * 6)):
        options = RibsOptions(archive="grid", cells=cells, stations=tuple(np.linspace(0.1, 1, stations)))
        assert make_archive(options, [(-1.0, 1.0)] * stations, 0).dims.tolist() == dims


def test_the_centroids_of_a_cvt_archive_follow_from_the_seed_and_fill_the_heights():
    options = RibsOptions(cells=40)
    one, same, other = (
        make_archive(options, [(-0.7, 0.7)] * len(options.stations), seed).centroids for seed in (3, 3, 4)
    )
    assert one.shape == (40, 3)
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()
    assert (np.abs(one) <= 0.7).all() and np.ptp(one, axis=0).min() > 0.9


def test_of_flights_alike_the_fitter_is_kept_and_breeds():
    search = strategy(cells=100, stations=(0.5, 1.0), random=4, batch=300, crossover=0)
    genomes = [candidate.genome for candidate in search.ask(10)]
    flights = [rising(0.5), rising(0.51), rising(-0.5), None]
    fitness = [50.0, 60.0, 10.0, 0.0]
    search.tell(
        0,
        [
            Evaluation(genome, np.array([score]), path, None if path is not None else "it broke")
            for genome, score, path in zip(genomes, fitness, flights, strict=True)
        ],
    )
    parents = Counter(candidate.parents for candidate in search.ask(300))
    assert set(parents) == {(1,), (2,)}
    assert abs(parents[1,] - 150) < 5 * np.sqrt(300 * 0.25)


@pytest.mark.parametrize(("objective", "kept"), [("best", 0), ("mean", 1)])
def test_fitter_means_the_best_for_any_target_or_the_mean_over_all(objective, kept):
    space = SearchSpace(GRAMMAR, ("T", "U"), np.random.default_rng(0), SCENARIO)
    search = RibsStrategy(RibsOptions(archive="grid", cells=8, random=2, batch=20, objective=objective), space)
    genomes = [candidate.genome for candidate in search.ask(2)]
    scores = [np.array([90.0, 0.0]), np.array([50.0, 60.0])]
    search.tell(0, [Evaluation(g, s, rising(0.1)) for g, s in zip(genomes, scores, strict=True)])
    assert {parent for candidate in search.ask(20) for parent in candidate.parents} == {kept}


def test_the_archive_keeps_genomes_of_any_length_as_they_are():
    archive = make_archive(RibsOptions(archive="grid", cells=16, stations=(0.5, 1.0)), [(-1.0, 1.0)] * 2, 0)
    genomes = [Genome("any", ("x",)), Genome("any", ("x", "yy", "z"))]
    archive.add(as_objects(genomes), np.ones(2), np.array([[-0.5, 0], [0.5, 0]]), evaluation=np.array([4, 7]))
    assert sorted(archive.data("solution"), key=lambda g: len(g.symbols)) == genomes


def test_it_begins_with_random_genomes_and_then_names_the_parents_of_each():
    search = strategy(cells=16, stations=(0.5, 1.0), random=2, batch=40, crossover=0.5, mutation_rate=0.1)
    first = search.ask(40)
    assert [candidate.parents for candidate in first] == [(), ()]
    elites = [candidate.genome for candidate in first]
    search.tell(0, [Evaluation(g, np.ones(1), rising(r)) for g, r in zip(elites, (-0.5, 0.5), strict=True)])
    for candidate in search.ask(40):
        assert set(candidate.parents) <= {0, 1} and len(candidate.parents) in (1, 2)
        assert all(candidate.genome != elites[parent] for parent in candidate.parents)


def test_open_water_is_refused_in_one_line():
    space = SearchSpace(GRAMMAR, (), np.random.default_rng(0))
    with pytest.raises(InputError, match="open water"):
        RibsStrategy(RibsOptions(), space)


def test_the_plugin_is_found_and_pyribs_is_not_imported_for_its_name(monkeypatch):
    monkeypatch.delitem(sys.modules, "ribs", raising=False)
    monkeypatch.delitem(sys.modules, "ribs.archives", raising=False)
    registry.cache_clear()
    assert registry().find("strategy", "ribs").__name__ == "RibsStrategy"
    assert "ribs" not in sys.modules


def test_without_pyribs_it_says_so(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ModuleNotFoundError, match="No module named 'ribs'"):
        driftform_ribs.driftform_strategy()
