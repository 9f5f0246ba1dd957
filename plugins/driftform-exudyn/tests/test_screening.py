"""Exudyn checks its flights itself, and screens them itself."""

import numpy as np
import pytest

from driftform.motion.solver import error
from driftform.study import load_study

PIPELINE = load_study("paper", use={"simulator": "exudyn"}).make_pipeline()
GENOMES = [PIPELINE.grammar.random(np.random.default_rng(0))]


def test_exudyn_flies_without_the_native_integrator(monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("the native integrator was called")

    for module, name in ((error, "integrate"), (error, "integrate_once"), (error, "take_all_steps")):
        monkeypatch.setattr(module, name, refuse)
    with pytest.raises(AssertionError, match="native"):
        load_study("paper").make_pipeline().simulator.simulate(PIPELINE.make_agent(GENOMES[0]), PIPELINE.scenario)
    [checked] = PIPELINE.evaluate(GENOMES[:1])
    [unchecked] = PIPELINE.evaluate(GENOMES[:1], thresholds=[(100.0,) * 10])
    assert checked.trajectory.error <= 1e-3 and unchecked.trajectory.error is None
