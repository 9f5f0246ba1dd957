"""The environment as data: what goes together, and what it gives to others."""

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.study import load_study
from driftform.types import MassProperties
from driftform.water import Scenario
from driftform.water.flow import FLOWS, GridFlow, UniformFlow
from driftform.water.scenario import Release

PIPE = {"segments": [{"start": [0, 0, 0], "end": [9.0, 0, 0], "radius": 1.0}]}


def scenario(**tables):
    return Scenario.model_validate({"pipe": PIPE, **tables})


def test_the_current_follows_the_first_segment():
    along = {"segments": [{"start": [1, 0, 0], "end": [1, 3, 4], "radius": 1.0}]}
    release = {"position": [1, 0, 0]}
    turned = Scenario.model_validate({"pipe": along, "release": release, "flow": {"speed": 2.0}})
    assert turned.current() == pytest.approx([0, 1.2, 1.6])
    assert Scenario(flow=UniformFlow(speed=0.7)).current() == pytest.approx([0.7, 0, 0])


def test_gusts_of_an_evaluation_are_those_of_its_seed_and_index_alone():
    gusty = scenario(flow={"kind": "turbulent"}, gusts={"seed": 5, "strength": 0.5})
    seeds = np.array([[gusty.of_evaluation(seed, k).gusts.seed for k in range(20)] for seed in range(20)])
    assert len(np.unique(seeds)) == 400
    third = gusty.of_evaluation(3, 4)
    assert third.gusts == gusty.gusts.model_copy(update={"seed": int(seeds[3, 4])})
    assert third.model_copy(update={"gusts": gusty.gusts}) == gusty
    assert third.of_evaluation(3, 4) == third


@pytest.mark.parametrize("name", ["uniform", "flow", "pipe"])
def test_a_target_may_have_the_name_of_a_kind_or_a_table(name):
    moved = load_study("paper", settings=[f"targets={{{name}=[1, 0, 0]}}"])
    assert moved.scenario.target_names == (name,)
    with pytest.raises(InputError, match=rf"targets\.{name}\[2\] = 'a': should be a number"):
        load_study("paper", settings=[f'targets={{{name}=[1, 0, "a"]}}'])


def test_a_ballast_is_a_point_that_displaces_its_own_water():
    m, x, a, lead = 0.2, 0.01, 0.07, 0.03
    mass = MassProperties(m, np.array([x, 0, 0]), np.diag([1e-4, 3e-4, 3e-4]), 1.8e-4, np.array([0.02, 0, 0]))
    found = Release(ballast=lead, ballast_x=a, ballast_density=11_000.0).load(mass)
    water, centre = lead / 11_000.0, (m * x + lead * a) / (m + lead)
    assert found.mass == pytest.approx(m + lead, rel=1e-12)
    assert found.cog == pytest.approx([centre, 0, 0], rel=1e-12)
    # Of two points, the reduced mass times the square of their distance.
    across = 3e-4 + m * lead / (m + lead) * (a - x) ** 2
    assert found.inertia == pytest.approx(np.diag([1e-4, across, across]), rel=1e-9)
    assert found.volume == pytest.approx(1.8e-4 + water, rel=1e-12)
    moment = 1.8e-4 * 0.02 + water * a
    assert found.cob == pytest.approx([moment / (1.8e-4 + water), 0, 0], rel=1e-12)
    assert Release().load(mass) is mass


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
            ["flow.kind=log_law", "flow.exponent=7"],
            [
                "--set flow.exponent=7: unknown key 'exponent' in [flow] of kind 'log_law'; known: ",
                "kind, roughness, speed, swirl, upstream",
            ],
        ),
        (["flow.kind=power_law", "flow.speed=0"], ["flow.speed = 0", "greater than or equal to 0.0001 m/s"]),
        (["pipe.segments=[]", "targets={}", "flow.kind=log_law"], ["needs a pipe", "it must be 'uniform' or 'grid'"]),
    ],
)
def test_a_fault_of_a_flow_is_one_line_with_its_key_and_not_its_table(settings, parts):
    with pytest.raises(InputError) as caught:
        load_study("paper", settings=settings, run={"seed": 1})
    [line] = caught.value.args
    assert all(part in line for part in parts) and "tag" not in line, "that is pydantic's word"
