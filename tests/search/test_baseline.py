"""The baseline of a target."""

import pytest

from driftform.search.baseline import tune_baselines
from driftform.search.local import InProcess
from driftform.study import load_study


@pytest.mark.parametrize(("z", "sinks"), [(-0.7, True), (0.7, False)])
def test_a_baseline_sinks_or_rises_to_a_target_in_water_at_rest(z, sinks):
    still = ["flow={kind = 'uniform', speed = 0.0}", f"targets={{T = [0.0, 0.0, {z}]}}"]
    study = load_study("pipe-inspection", still, use={"simulator": "native"})
    plain = tune_baselines(study, InProcess(study.make_pipeline()), [0])[0]
    assert plain.net_weight > 0 if sinks else plain.net_weight < 0
    assert plain.kind == "sphere of 45 mm"


def test_there_is_no_baseline_where_no_plain_body_can_be_tuned():
    study = load_study("pipe-inspection", ["builder.core_mass=3.0", "builder.core=custom"], use={"simulator": "native"})
    assert tune_baselines(study, InProcess(study.make_pipeline()), [0]) == {}
