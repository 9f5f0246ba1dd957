"""The kinds of flow, and what is wrong with one in one line."""

import pytest

from driftform.errors import InputError
from driftform.study import load_study
from driftform.water import Scenario
from driftform.water.flow import FLOWS, GridFlow

PIPE = {"segments": [{"start": [0, 0, 0], "end": [9.0, 0, 0], "radius": 1.0}]}


def scenario(**tables):
    return Scenario.model_validate({"pipe": PIPE, **tables})


def test_every_kind_of_flow_is_known_by_its_name_and_survives_a_round_trip():
    for kind, model in FLOWS.items():
        if model is GridFlow:
            continue  # It needs a file.
        whole = scenario(flow={"kind": kind})
        assert type(whole.flow) is model
        assert whole.flow.kind == kind
        assert Scenario.model_validate(whole.model_dump(mode="json")) == whole
        study = load_study("paper", [f"flow.kind={kind}"], run={"seed": 1})
        assert study.scenario.flow == model()
        assert study.document["flow"]["kind"] == kind


@pytest.mark.parametrize("kind", ["log_law", "developed", "turbulent"])
def test_the_roughness_is_limited_by_the_validity_of_the_friction_law(kind):
    # Colebrook's law, and Moody's chart, end at a roughness of a twentieth of the diameter.
    assert scenario(flow={"kind": kind, "roughness": 0.1}).flow.roughness == 0.1
    with pytest.raises(InputError) as caught:
        load_study("paper", settings=[f"flow.kind={kind}", "flow.roughness=0.101"])
    [line] = caught.value.args
    assert line.startswith("--set flow.roughness=0.101: flow.roughness = 0.101 is too large")
    assert "0.1 m" in line


@pytest.mark.parametrize(
    ("settings", "parts"),
    [
        (
            ["flow.kind=3"],
            ["flow.kind = 3", "known: developed, developing, grid, log_law, power_law, turbulent, uniform"],
        ),
        (['flow.kind="power_lw"'], ["flow.kind = 'power_lw'", "did you mean 'power_law'?"]),
        (
            ["flow.kind=log_law", "flow.exponent=7"],
            [
                "--set flow.exponent=7: unknown key 'exponent' in [flow] of kind 'log_law'; known: ",
                "kind, roughness, speed, swirl, upstream",
            ],
        ),
        (["flow.kind=power_law", "flow.speed=0"], ["flow.speed = 0", "greater than or equal to 0.0001 m/s"]),
        (["flow.kind=uniform", "flow.speed=inf"], ["flow.speed = inf"]),
        (["pipe.segments=[]", "targets={}", "flow.kind=log_law"], ["needs a pipe", "it must be 'uniform' or 'grid'"]),
    ],
)
def test_a_fault_of_a_flow_is_one_line_with_its_key_and_not_its_table(settings, parts):
    with pytest.raises(InputError) as caught:
        load_study("paper", settings=settings, run={"seed": 1})
    [line] = caught.value.args
    assert all(part in line for part in parts) and "tag" not in line, "that is pydantic's word"
