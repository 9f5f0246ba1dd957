"""Evaluations: which flights are checked."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from driftform.errors import WorkFailedError
from driftform.interfaces import Measure
from driftform.pipeline import MARGIN
from driftform.study import load_study

NOWHERE, ANYWHERE = (np.inf,) * 10, (-np.inf,) * 10


@pytest.fixture(scope="module")
def pipeline():
    return load_study("paper").make_pipeline()


@pytest.fixture(scope="module")
def genomes(pipeline):
    rng = np.random.default_rng(4)
    return [pipeline.grammar.random(rng) for _ in range(6)]


@pytest.fixture(scope="module")
def checked(pipeline, genomes):
    return pipeline.evaluate(genomes)


def test_without_a_threshold_every_flight_is_checked(checked):
    assert all(evaluation.trajectory.error <= 1e-3 for evaluation in checked)


def test_below_its_threshold_a_flight_is_unchecked_and_nearly_the_same(pipeline, genomes, checked):
    screened = pipeline.evaluate(genomes, thresholds=[NOWHERE] * len(genomes))
    assert [evaluation.trajectory.error for evaluation in screened] == [None] * len(genomes)
    assert [evaluation.failure for evaluation in screened] == [None] * len(genomes)
    difference = np.array([a.fitness - b.fitness for a, b in zip(screened, checked, strict=True)])
    assert 0 < np.median(np.abs(difference)) < 0.01


def test_above_its_threshold_a_flight_is_checked_to_the_last_digit(pipeline, genomes, checked):
    thresholds = [ANYWHERE, NOWHERE, None] * 2
    mixed = pipeline.evaluate(genomes, thresholds=thresholds)
    for threshold, evaluation, expected in zip(thresholds, mixed, checked, strict=True):
        if threshold is NOWHERE:
            assert evaluation.trajectory.error is None
        else:
            np.testing.assert_array_equal(evaluation.fitness, expected.fitness)
            np.testing.assert_array_equal(evaluation.trajectory.position, expected.trajectory.position)
            assert evaluation.trajectory.error == expected.trajectory.error


@pytest.mark.parametrize(("below", "is_checked"), [(0.9 * MARGIN, True), (1.1 * MARGIN, False)])
def test_one_target_within_the_margin_below_its_threshold_is_enough(pipeline, genomes, below, is_checked):
    [screened] = pipeline.evaluate(genomes[:1], thresholds=[NOWHERE])
    threshold = (*NOWHERE[:-1], float(screened.fitness[-1]) + below)
    [evaluation] = pipeline.evaluate(genomes[:1], thresholds=[threshold])
    assert (evaluation.trajectory.error is not None) is is_checked


def test_a_flight_that_fails_without_a_check_is_checked(pipeline, genomes):
    options = pipeline.simulator.options.model_copy(update={"step_limit": 20})
    short = replace(pipeline, simulator=type(pipeline.simulator)(options))
    [screened], [expected] = (short.evaluate(genomes[:1], thresholds=[threshold]) for threshold in (NOWHERE, None))
    assert screened.failure == expected.failure is not None
    assert screened.trajectory.error == expected.trajectory.error


def test_a_pipeline_that_has_made_agents_makes_the_same_ones_in_another_process(pipeline, genomes):
    made = pipeline.make_agent(genomes[0])
    sent = pickle.loads(pickle.dumps(pipeline))
    np.testing.assert_array_equal(sent.make_agent(genomes[0]).mass.inertia, made.mass.inertia)
    np.testing.assert_array_equal(sent.make_agent(genomes[0]).coefficients.added_mass, made.coefficients.added_mass)


def test_an_evaluation_measures_agent_and_flight_and_what_its_fitness_measures(pipeline, genomes, monkeypatch):
    monkeypatch.setattr(pipeline.fitness, "measures", {"height": Measure("at the end", "m", -1, 1)}, raising=False)
    monkeypatch.setattr(pipeline.fitness, "find_measures", lambda t, *_: {"height": t.position[-1, 2]}, raising=False)
    [found] = pipeline.evaluate(genomes[:1])
    agent = pipeline.make_agent(genomes[0])
    weight = agent.mass.mass - pipeline.scenario.fluid.density * agent.mass.volume
    assert (
        found.measures["net_weight"] == pytest.approx(weight)
        and found.measures["height"] == found.trajectory.position[-1, 2]
    )
    x, _, z = found.trajectory.position.T
    passed = int(np.argmax(x >= 4.5))
    half_way = np.interp(4.5, x[passed - 1 : passed + 1], z[passed - 1 : passed + 1])
    assert found.measures["height_0.5"] == pytest.approx(half_way, abs=1e-12)
    # A metre of filament holds 2.405 ml.
    hull = 1e3 * found.measures["print_mass"] / agent.body.hull_density
    assert found.measures["filament"] == pytest.approx(hull / 2.405e-3, rel=1e-3)
    assert found.violations == {"port": 0.0, "bore": 0.0, "release": 0.0}
    monkeypatch.setattr(pipeline.fitness, "find_measures", lambda *_: {"height": 2.0}, raising=False)
    assert "expected a number from -1 to 1 for 'height'" in pipeline.evaluate(genomes[:1])[0].failure
    monkeypatch.setattr(pipeline.fitness, "find_measures", lambda *_: {"depth": 2.0}, raising=False)
    assert "expected the measures height" in pipeline.evaluate(genomes[:1])[0].failure


def test_a_body_that_is_too_wide_says_by_how_much(pipeline, genomes):
    wide = pipeline.make_agent(genomes[0]).body.max_diameter
    release = pipeline.scenario.release.model_copy(update={"port": wide - 0.002})
    narrow = replace(pipeline, scenario=pipeline.scenario.model_copy(update={"release": release}))
    [found] = narrow.evaluate(genomes[:1])
    assert found.failure and found.violations["port"] == pytest.approx(0.002) and not found.violations["bore"]


def test_a_body_released_in_the_wall_says_how_far_it_reaches_into_it(pipeline, genomes):
    # The pipe has a radius of 1 m, and the body's nose points along it.
    for height in (1.0, 1.1):
        release = pipeline.scenario.release.model_copy(update={"position": (0.5, 0.0, height)})
        [found] = replace(pipeline, scenario=pipeline.scenario.model_copy(update={"release": release})).evaluate(
            genomes[:1]
        )
        half = 0.5 * pipeline.make_agent(genomes[0]).body.max_diameter
        assert found.failure and found.violations["release"] == pytest.approx(height - 1.0 + half, rel=1e-6)


def test_a_constraint_that_a_plugin_names_is_told_stored_and_shown(pipeline, genomes, monkeypatch):
    def build(morphology):
        raise WorkFailedError("too weak", violations={"strength": 0.25})

    monkeypatch.setattr(pipeline.builder, "build", build, raising=False)
    [found] = replace(pipeline).evaluate(genomes[:1])
    assert found.failure == "too weak" and found.violations == {"strength": 0.25}
    monkeypatch.undo()
    monkeypatch.setattr(
        pipeline.fitness, "measures", {"draught": Measure("at the end", "m", is_violation=True)}, raising=False
    )
    monkeypatch.setattr(pipeline.fitness, "find_measures", lambda *_: {"draught": 0.5}, raising=False)
    [found] = pipeline.evaluate(genomes[:1])
    assert found.failure is None and found.violations["draught"] == 0.5 and "draught" not in found.measures
