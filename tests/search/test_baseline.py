"""The baseline of a target."""

import numpy as np
import pytest

from driftform.search.baseline import DRAG, _find_tuning, tune_baselines
from driftform.search.local import InProcess
from driftform.study import load_study


@pytest.mark.parametrize(("z", "sinks"), [(-0.7, True), (0.7, False)])
def test_a_baseline_sinks_or_rises_to_a_target_in_water_at_rest(z, sinks):
    still = ["flow={kind = 'uniform', speed = 0.0}", f"targets={{T = [0.0, 0.0, {z}]}}"]
    study = load_study("pipe-inspection", still, use={"simulator": "native"})
    plain = tune_baselines(study, InProcess(study.make_pipeline()), [0])[0]
    assert plain.net_weight > 0 if sinks else plain.net_weight < 0
    assert plain.kind == "sphere of 45 mm"


def test_a_baseline_is_tuned_finer_than_the_first_speeds_that_are_tried():
    even = ["flow={kind = 'uniform', speed = 1.0}", "targets={T = [5.0, 0.0, -0.33]}"]
    study = load_study("pipe-inspection", even, use={"simulator": "native"})
    pipeline = study.make_pipeline()
    [flight] = pipeline.evaluate([tune_baselines(study, InProcess(pipeline), [0])[0].genome])
    assert flight.fitness[0] > 99.8


@pytest.mark.parametrize(("core", "kind", "sinking"), [("steel-20mm", "sphere", 0.3), ("steel-30mm", "capsule", -0.2)])
def test_a_plain_body_is_first_given_the_weight_that_its_drag_bears(core, kind, sinking):
    pipeline = load_study("pipe-inspection", [f"builder.core={core}"], use={"simulator": "native"}).make_pipeline()
    plain = _find_tuning(pipeline)(sinking)
    assert plain.kind.startswith(kind)
    across = np.pi / 4 * plain.diameter**2 + plain.diameter * (plain.length - plain.diameter)
    water = pipeline.scenario.fluid
    bears = 0.5 * water.density * DRAG * across * sinking * abs(sinking)
    assert plain.net_weight * water.gravity == pytest.approx(bears, rel=0.1)


def test_there_is_no_baseline_where_no_plain_body_can_be_tuned():
    study = load_study("pipe-inspection", ["builder.core_mass=3.0", "builder.core=custom"], use={"simulator": "native"})
    assert tune_baselines(study, InProcess(study.make_pipeline()), [0]) == {}
