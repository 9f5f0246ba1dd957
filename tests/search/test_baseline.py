"""The baseline of a target."""

import numpy as np
import pytest

from driftform.search.baseline import Aim, tune_baselines
from driftform.search.local import InProcess
from driftform.study import load_study


@pytest.mark.parametrize(("z", "sinks"), [(-0.7, True), (0.7, False)])
def test_a_baseline_sinks_or_rises_to_a_target_in_water_at_rest(z, sinks):
    still = ["flow={kind = 'uniform', speed = 0.0}", f"targets={{T = [0.0, 0.0, {z}]}}"]
    study = load_study("pipe-inspection", still, use={"simulator": "native"})
    pipeline = study.make_pipeline()
    genome = pipeline.grammar.random(np.random.default_rng(1))
    aim = Aim(0, genome, pipeline.make_agent(genome).body)
    plain = tune_baselines(study, InProcess(pipeline), [aim])[0]
    assert plain.net_weight > 0 if sinks else plain.net_weight < 0
