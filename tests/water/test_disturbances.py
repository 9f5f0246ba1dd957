"""Disturbed conditions: how they are drawn, and what they change."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ndtr
from scipy.stats import qmc

from driftform.agent import mass_properties
from driftform.study import load_study
from driftform.water import Scenario
from driftform.water.disturbances import (
    BEYOND,
    COEFFICIENT,
    MAX_DEVIATION,
    SCALE,
    THERMOMETER,
    Condition,
    Specimen,
    disturb_scenario,
    draw_conditions,
    draw_latin_hypercube,
    draw_normals,
    stop_after_targets,
)
from driftform.water.scenario import Robustness

CALM = Condition((0.0, 0.0), 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 7)


def changed(**values):
    return Condition(**{**CALM.__dict__, **values})


def pipe(**tables):
    segment = {"start": (0.0, 0.0, 0.0), "end": (9.0, 0.0, 0.0), "radius": 1.0}
    return Scenario.model_validate({"pipe": {"segments": (segment,)}, **tables})


def test_the_latin_hypercube_is_that_of_scipy():
    theirs = qmc.LatinHypercube(9, rng=np.random.default_rng(3)).random(70)
    # SciPy draws from a child of the generator.
    np.testing.assert_array_equal(draw_latin_hypercube(np.random.default_rng(3).spawn(1)[0], 70, 9), theirs)


def test_the_share_beyond_the_largest_deviation_is_that_of_a_normal_distribution():
    assert ndtr(-MAX_DEVIATION) == pytest.approx(BEYOND, rel=1e-14)


def test_the_conditions_follow_the_distributions_that_the_scenario_gives():
    asked = Robustness(
        **{
            "position": 0.05,
            "angle_deg": 4.0,
            "current": 0.1,
            "density": 0.02,
            "mass": 0.03,
            "wall": 1e-4,
            "drag": 0.15,
        },
        **{"outside": 2e-4, "shrinkage": 0.004, "temperature": 8.0, "bubble": 3e-7, "absorbed": 0.002},
    )
    drawn = draw_conditions(asked, 2000, (1,))
    deviation = 0.98658  # of a standard normal cut off at three: sqrt(1 - 6 phi(3) / (2 Phi(3) - 1))
    for found, wanted in (
        ([c.across[0] for c in drawn], 0.05),
        ([c.across[1] for c in drawn], 0.05),
        ([c.pitch for c in drawn], np.deg2rad(4.0)),
        ([c.yaw for c in drawn], np.deg2rad(4.0)),
        ([c.current - 1 for c in drawn], 0.1),
        ([c.density - 1 for c in drawn], 0.02),
        ([c.mass - 1 for c in drawn], 0.03),
        ([c.wall for c in drawn], 1e-4),
        ([c.drag - 1 for c in drawn], 0.15),
        ([c.outside for c in drawn], 2e-4),
        ([c.scale - 1 for c in drawn], 0.004),
        ([c.warmer for c in drawn], 8.0),
        ([c.bubble for c in drawn], 3e-7),
        ([c.expanded - 1 for c in drawn], COEFFICIENT),
        ([c.squeezed - 1 for c in drawn], COEFFICIENT),
    ):
        # A Latin hypercube of n has its mean right to about 1/n of a deviation, not 1/sqrt(n).
        assert np.mean(found) == pytest.approx(0, abs=0.003 * wanted)
        assert np.std(found) == pytest.approx(deviation * wanted, rel=0.005)
        assert np.abs(found).max() <= 3 * wanted
    # Water is taken up, and the error of a thermometer is even; what a scale leaves is the sum of two even roundings.
    absorbed, read, left = np.array([(c.absorbed, c.read, c.left) for c in drawn]).T
    assert absorbed.min() >= 0 and absorbed.mean() == pytest.approx(0.002 * math.sqrt(2 / math.pi), rel=0.02)
    assert abs(read).max() <= THERMOMETER and read.std() == pytest.approx(THERMOMETER / math.sqrt(3), rel=0.01)
    assert abs(left).max() <= SCALE and left.std() == pytest.approx(SCALE / math.sqrt(6), rel=0.03)
    assert abs(left.mean()) < 0.02 * SCALE
    assert len({c.gusts for c in drawn}) == 2000
    assert (
        np.abs(
            np.corrcoef([[*c.across, c.pitch, c.yaw, c.current, c.mass] for c in drawn], rowvar=False) - np.eye(6)
        ).max()
        < 0.1
    )


def test_the_same_seed_draws_the_same_conditions_and_another_one_others():
    asked = Robustness()
    assert draw_conditions(asked, 5, (3,)) == draw_conditions(asked, 5, (3,)) != draw_conditions(asked, 5, (4,))
    assert draw_conditions(asked, 0, (3,)) == ()


def test_a_condition_without_deviations_changes_nothing():
    scenario = load_study("paper").scenario
    assert disturb_scenario(CALM, scenario) == scenario


def test_every_disturbance_changes_its_quantity():
    scenario = pipe(flow={"kind": "turbulent", "speed": 2.0}, release={"pitch_deg": 10.0})
    there = disturb_scenario(changed(across=(0.1, -0.2), pitch=0.1, yaw=-0.2, current=1.5, density=0.9), scenario)
    assert there.release.position == pytest.approx((0.0, 0.1, -0.2))
    assert there.release.pitch_deg == pytest.approx(10 + np.rad2deg(0.1))
    assert there.release.yaw_deg == pytest.approx(np.rad2deg(-0.2))
    assert there.flow.speed == pytest.approx(3.0)
    assert (there.gusts.seed, there.gusts.always) == (7, True)
    assert there.fluid.density == pytest.approx(0.9 * scenario.fluid.density)
    across = Scenario(flow={"kind": "uniform", "speed": 1.0, "added": (0.0, 0.2, 0.0)})
    assert disturb_scenario(changed(current=1.5), across).flow.added == pytest.approx((0.0, 0.3, 0.0))
    warm = disturb_scenario(changed(warmer=4.0, density=0.9), scenario).fluid
    assert warm.density == pytest.approx(0.9 * scenario.fluid.density_at(scenario.fluid.celsius + 4))


@pytest.mark.parametrize("end", [(0.0, 9.0, 0.0), (3.0, 4.0, 5.0)])
def test_the_offset_of_a_release_is_across_the_pipe_whichever_way_that_leads(end):
    scenario = Scenario.model_validate({"pipe": {"segments": ({"start": (0, 0, 0), "end": end, "radius": 1.0},)}})
    there = disturb_scenario(changed(across=(0.1, -0.2)), scenario)
    level, up = draw_normals(scenario.direction())
    assert there.release_position() - scenario.release_position() == pytest.approx(0.1 * level - 0.2 * up)


def test_disturbed_flights_meet_gusts_in_a_flow_that_has_their_mean():
    flow = {"kind": "log_law", "speed": 1.5, "roughness": 0.001}
    steady = pipe(flow=flow, gusts={"strength": 0.3, "memory": 2.0})
    gusty = disturb_scenario(changed(current=1.1), steady)
    assert gusty.has_gusts and not steady.has_gusts
    assert (gusty.flow.kind, gusty.flow.roughness) == ("log_law", 0.001)
    assert (gusty.gusts.seed, gusty.gusts.strength, gusty.gusts.memory) == (7, 0.3, 2.0)
    assert gusty.flow.speed == pytest.approx(1.65)
    assert not disturb_scenario(changed(gusts=None), steady).has_gusts
    for kind, table in (("uniform", {}), ("developing", {}), ("log_law", {"strength": 0.0})):
        calm = pipe(flow={"kind": kind}, gusts=table)
        assert not disturb_scenario(changed(), calm).has_gusts
    assert all(c.gusts is None for c in draw_conditions(Robustness(gusts=False), 3, (1,)))


def test_what_is_not_known_of_gusts_is_disturbed_and_changes_no_other_draw():
    asked = Robustness(gust_strength=0.1, gust_memory=0.2, gust_crossing=0.3)
    drawn = draw_conditions(asked, 2000, (1,))
    factors = np.array([c.turbulence for c in drawn])
    deviation = 0.98658  # of a standard normal cut off at three
    assert factors.mean(axis=0) == pytest.approx([1, 1, 1], abs=1e-3)
    assert factors.std(axis=0) == pytest.approx(deviation * np.array([0.1, 0.2, 0.3]), rel=0.01)
    assert np.abs(np.corrcoef(factors.T) - np.eye(3)).max() < 0.07
    known = draw_conditions(Robustness(gust_strength=0.0, gust_memory=0.0, gust_crossing=0.0), 2000, (1,))
    assert known == tuple(replace(c, turbulence=(1.0, 1.0, 1.0)) for c in drawn)


def test_a_disturbed_flight_has_the_strength_memory_and_crossing_of_its_condition():
    scenario = pipe(flow={"kind": "log_law"}, gusts={"strength": 0.5, "memory": 2.0, "crossing": 0.4})
    there = disturb_scenario(changed(turbulence=(1.2, 0.7, 1.5)), scenario).gusts
    assert (there.strength, there.memory, there.crossing) == pytest.approx((0.6, 1.4, 0.6))
    assert disturb_scenario(changed(gusts=None, turbulence=(1.2, 0.7, 1.5)), scenario).gusts == scenario.gusts


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_a_disturbed_release_stays_in_the_bore(y, z):
    position = disturb_scenario(changed(across=(y, z)), pipe(release={"position": (0.0, 0.5, -0.7)})).release.position
    assert np.hypot(position[1], position[2]) <= 1.0
    if np.hypot(0.5 + y, z - 0.7) < 0.9:
        assert position == pytest.approx((0.0, 0.5 + y, z - 0.7))


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 0, 1), (0, 0, -1), (0.6, 0.8, 0), (0.6, 0, 0.8)])
def test_the_normals_of_a_direction_are_square_to_it_and_to_each_other(direction):
    level, up = draw_normals(np.array(direction, dtype=float))
    frame = np.array([direction, level, up])
    assert frame @ frame.T == pytest.approx(np.eye(3))
    assert level[2] == pytest.approx(0)


def test_disturbed_flights_do_not_depend_on_the_rest_of_their_batch():
    pipeline = load_study("paper").make_pipeline()
    conditions = draw_conditions(Robustness(), 3, (5,))
    rng = np.random.default_rng(1)
    first, second = pipeline.grammar.random(rng), pipeline.grammar.random(rng)
    genomes, under = [first, second, first, first], [*conditions, None]
    together = pipeline.evaluate(genomes, conditions=under)
    alone = [pipeline.evaluate([g], conditions=[c])[0] for g, c in zip(genomes, under, strict=True)]
    for a, b in zip(together, alone, strict=True):
        assert a.failure is None
        assert a.fitness.tolist() == b.fitness.tolist()
    assert together[0].fitness.tolist() != together[3].fitness.tolist()


def test_a_disturbed_flight_for_some_targets_ends_behind_them_and_passes_them_as_the_whole_flight_does():
    pipeline = load_study("pipe-inspection", use={"simulator": "native"}).make_pipeline()
    # Bodies that do not come to rest on the floor.
    conditions, rng = draw_conditions(Robustness(), 6, (5,)), np.random.default_rng(4)
    genomes, names = [pipeline.grammar.random(rng) for _ in conditions], list(pipeline.scenario.targets)
    for name in ("TP1", "TP4"):
        wanted, number = tuple(target == name for target in names), names.index(name)
        whole = pipeline.evaluate(genomes, conditions=conditions)
        short = pipeline.evaluate(genomes, conditions=conditions, wanted=[wanted] * len(genomes))
        behind = pipeline.scenario.targets[name][0] + 2.0
        for longer, shorter in zip(whole, short, strict=True):
            assert shorter.fitness[number] == pytest.approx(longer.fitness[number], abs=0.1)
            assert shorter.trajectory.position[-1, 0] == pytest.approx(behind, abs=1e-9)
            # Without the rest of the flight it takes fewer steps, often with the same tolerance.
            assert len(shorter.trajectory.t) < len(longer.trajectory.t)
        assert sum(a.fitness[number] == b.fitness[number] for a, b in zip(whole, short, strict=True)) >= 3
    undisturbed = pipeline.evaluate(genomes[:1], wanted=[(True,) + (False,) * 9])
    assert undisturbed[0].trajectory.position[-1, 0] == pytest.approx(9.0)


def laid(axis, along, radius, flow, release=0.0):
    start = np.array([0.5, -1.0, 2.0])
    segment = {"start": tuple(start.tolist()), "end": tuple((start + 9 * axis).tolist()), "radius": radius}
    targets = {f"T{n}": tuple((start + s * axis).tolist()) for n, s in enumerate(along)}
    tables = {"pipe": {"segments": (segment,)}, "targets": targets, "flow": flow}
    return Scenario.model_validate(tables | {"release": {"position": (release, 0.0, 0.0)}}), start


@given(
    st.floats(-3, 3), st.lists(st.floats(0.1, 8.9), min_size=1, max_size=3), st.floats(0.05, 1.0), st.floats(0.0, 8.0)
)
def test_a_level_pipe_ends_a_bore_behind_the_last_wanted_target_and_the_release(angle, along, radius, release):
    axis = np.array([np.cos(angle), np.sin(angle), 0.0])
    scenario, start = laid(axis, along, radius, {"kind": "developed", "speed": 1.0}, release)
    wanted = [True] + [False] * (len(along) - 1)
    end = np.array(stop_after_targets(scenario, wanted).pipe.straight.end)
    assert (end - start) @ axis == pytest.approx(min(9.0, max(along[0], release) + 2 * radius))
    assert stop_after_targets(scenario, [False] * len(along)) is scenario
    assert stop_after_targets(scenario, [True] * len(along)).pipe.straight.start == scenario.pipe.straight.start


@pytest.mark.parametrize(
    ("axis", "flow"),
    [((0.6, 0.0, 0.8), {"kind": "developed", "speed": 1.0}), ((1.0, 0.0, 0.0), {"kind": "uniform", "speed": 1.0})],
)
def test_a_pipe_stays_whole_if_a_flight_may_come_back(axis, flow):
    scenario, _ = laid(np.array(axis), [1.0], 0.1, flow)
    assert stop_after_targets(scenario, [True]) is scenario


def test_a_pipe_with_parts_stays_whole():
    scenario = load_study("t-junction").scenario
    assert stop_after_targets(scenario, [True] * len(scenario.targets)) is scenario


def test_disturbed_flights_have_the_secondary_flow_of_bends_and_no_other_draw_depends_on_it():
    drawn = draw_conditions(Robustness(swirl=0.1), 400, (5,))
    calm = draw_conditions(Robustness(swirl=0.0), 400, (5,))
    shares = np.array([condition.swirl for condition in drawn])
    # A half normal distribution, truncated: its mean is sqrt(2 / pi) of the deviation.
    assert shares.min() >= 0 and shares.max() <= 0.3
    assert shares.mean() == pytest.approx(0.1 * math.sqrt(2 / math.pi), rel=0.01)
    assert [replace(condition, swirl=0.0) for condition in drawn] == list(calm)
    scenario = load_study("pipe-inspection", ["flow.swirl=0.05"]).scenario
    assert disturb_scenario(drawn[0], scenario).flow.swirl == pytest.approx(0.05 + drawn[0].swirl)


def test_what_does_nothing_is_a_neutral_sphere_of_the_same_volume_in_the_same_water():
    study = load_study("pipe-inspection", use={"simulator": "native"}, run={"seed": 0})
    pipeline = study.make_pipeline()
    genome = pipeline.grammar.random(np.random.default_rng(5))
    baseline = pipeline.make_agent(genome, changed(density=1.002, mass=1.1, specimen=Specimen.IDLE))
    assert baseline.mass.volume == pytest.approx(mass_properties(pipeline.make_agent(genome).body).volume, rel=0.01)
    assert baseline.mass.mass == pytest.approx(1.002 * 999.1 * baseline.mass.volume, rel=1e-9)
    assert baseline.mass.cog == pytest.approx(baseline.mass.cob, abs=1e-12)
    [calm] = pipeline.evaluate([genome], conditions=[changed(gusts=None, specimen=Specimen.IDLE)])
    # Without gusts it stays on the axis, where it is released.
    assert np.abs(calm.trajectory.position[:, 1:]).max() < 1e-4
