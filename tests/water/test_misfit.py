"""A body that does not fit where it is released is refused with the two numbers, before it flies."""

import numpy as np
import pytest

from driftform.study import load_study
from driftform.types import Body, Core
from driftform.water import Scenario
from driftform.water.disturbances import Condition, disturb_scenario
from driftform.water.misfit import ease_release, find_misfit


def make_body(length, diameter):
    a, r = length / 2, diameter / 2
    outer = np.array([[-a, 0], [-a, r], [a, r], [a, 0]])
    return Body(outer, np.empty((0, 2)), np.array([-a, a]), Core(0.25 * diameter, 0.05), 0.001, 1050.0)


def make_scenario(radius=0.05, start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), **tables):
    segment = {"start": start, "end": end, "radius": radius}
    return Scenario.model_validate({"pipe": {"segments": [segment]}, **tables})


def test_a_body_wider_than_the_bore_is_refused_with_both_widths():
    assert find_misfit(make_body(0.2, 0.0999), make_scenario()) is None
    misfit = find_misfit(make_body(0.2, 0.12), make_scenario())
    assert misfit == "it is too wide for the pipe: 120 mm across, in a bore of 100 mm"


def test_a_body_that_is_wider_than_the_port_is_told_by_how_much():
    narrow = make_scenario(release={"port": 0.045})
    assert find_misfit(make_body(0.2, 0.045), narrow) is None
    misfit = find_misfit(make_body(0.2, 0.0523), narrow)
    assert misfit.startswith("it does not pass the port: 52.3 mm across, 7.3 mm more than release.port = 0.045 m")
    assert find_misfit(make_body(0.2, 0.0523), make_scenario()) is None


def test_a_print_of_a_body_as_wide_as_the_port_may_be_a_little_wider():
    usual = make_scenario(release={"port": 0.045})
    body = make_body(0.2, 0.045)
    assert find_misfit(body, usual) is None
    wider = make_body(0.2, 0.0452)
    assert find_misfit(wider, usual) is not None
    deviated = Condition((0.01, 0.0), 0.1, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0)
    disturbed = disturb_scenario(deviated, usual)
    assert ease_release(wider, usual, disturbed) == disturbed
    assert disturbed.release.pitch_deg != usual.release.pitch_deg


def test_a_release_across_the_bore_is_refused_with_reach_and_radius():
    misfit = find_misfit(make_body(0.204, 0.02), make_scenario(release={"pitch_deg": 90.0}))
    assert "reaches 102.5 mm" in misfit
    assert "radius 50 mm" in misfit
    assert "pitch_deg" in misfit


def test_a_vertical_pipe_takes_an_agent_along_its_axis():
    """Attitude is against the pipe's axis, so that a long agent is released along a vertical bore, not across it."""
    body = make_body(0.204, 0.02)
    up = {"start": (3.0, 2.0, 1.0), "end": (3.0, 2.0, 10.0)}
    assert find_misfit(body, make_scenario(**up)) is None
    assert find_misfit(body, make_scenario(**up, release={"frame": "world", "position": [3, 2, 1]})) is not None


@pytest.mark.parametrize("end", [(0, 0, 9), (0, 0, -9), (-9, 0, 0), (0, 9, 0), (3, 4, 5), (-3, 1, -5)])
def test_the_release_is_relative_to_the_inlet_and_the_axis_of_the_pipe(end):
    start = np.array([10.0, -4.0, 2.0])
    scenario = make_scenario(0.5, tuple(start), tuple(start + end), release={"position": [0.3, 0.2, 0.1]})
    along = np.array(end) / np.linalg.norm(end)
    np.testing.assert_allclose(scenario.release_axis(), along, atol=1e-12)
    shift = scenario.release_position() - start
    assert shift @ along == pytest.approx(0.3)
    frame = scenario.release_frame()
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1)
    assert frame[2, 1] == 0
    assert frame[2, 2] >= 0
    np.testing.assert_allclose(frame.T @ shift, [0.3, 0.2, 0.1], atol=1e-12)


def test_pitch_and_yaw_turn_against_the_pipe():
    turned = make_scenario(1.0, end=(0, 9, 0), release={"yaw_deg": 90.0})
    np.testing.assert_allclose(turned.release_axis(), [-1, 0, 0], atol=1e-12)
    pitched = make_scenario(1.0, end=(0, 9, 0), release={"pitch_deg": 90.0})
    np.testing.assert_allclose(pitched.release_axis(), [0, 0, -1], atol=1e-12)
    moving = make_scenario(1.0, end=(0, 9, 0), release={"velocity": [1.0, 0.0, 0.5]})
    np.testing.assert_allclose(moving.release_velocity(), [0, 1, 0.5], atol=1e-12)


def test_a_pipe_along_x_at_the_origin_has_the_world_frame_to_the_last_digit():
    release = {"position": [0.1, 0.2, -0.3], "pitch_deg": 17.0, "yaw_deg": -33.0, "velocity": [1, 0.1, 0]}
    inlet, world = (make_scenario(1.0, release={**release, "frame": f}) for f in ("inlet", "world"))
    np.testing.assert_array_equal(inlet.release_position(), world.release_position())
    np.testing.assert_array_equal(inlet.release_quaternion(), world.release_quaternion())
    np.testing.assert_array_equal(inlet.release_velocity(), world.release_velocity())


def test_a_body_whose_nose_is_in_the_wall_of_a_bend_is_refused():
    parts = [{"length": 0.3}, {"kind": "bend", "radius": 0.15}, {"length": 0.5}]
    scenario = Scenario.model_validate({"pipe": {"radius": 0.05, "parts": parts}})
    for x, fits in ((0.15, True), (0.28, False)):
        released = scenario.model_copy(update={"release": scenario.release.model_copy(update={"position": (x, 0, 0)})})
        assert (find_misfit(make_body(0.28, 0.02), released) is None) == fits


def test_a_release_above_the_water_is_refused():
    dry = make_scenario(1.0, fluid={"water_level": -0.5}, release={"position": [0, 0, 0.2]})
    assert "above the water" in (find_misfit(make_body(0.2, 0.05), dry) or "")
    wet = make_scenario(1.0, fluid={"water_level": -0.5}, release={"position": [0, 0, -0.49]})
    assert find_misfit(make_body(0.2, 0.05), wet) is None


def test_a_disturbed_release_stays_where_the_body_has_room():
    nominal, body = make_scenario(), make_body(0.2, 0.06)
    gone = Condition((0.045, 0.0), 0.4, -0.3, 1.0, 1.0, 1.0, 0.0, 1.0, 0)
    disturbed = disturb_scenario(gone, nominal)
    assert find_misfit(body, disturbed) is not None
    eased = ease_release(body, nominal, disturbed)
    assert find_misfit(body, eased) is None
    assert eased.release.pitch_deg > 0
    small = disturb_scenario(Condition((0.005, 0.0), 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0), nominal)
    assert ease_release(body, nominal, small) == small


def test_an_evaluation_says_why_its_genome_does_not_fit_and_flies_the_others():
    study = load_study(
        "paper", settings=["pipe.segments.0.radius=0.013", "targets={A=[1,0,0]}", "simulator.use=native"]
    )
    pipeline, rng = study.make_pipeline(), np.random.default_rng(3)
    genomes = [pipeline.grammar.random(rng) for _ in range(12)]
    evaluations = pipeline.evaluate(genomes)
    widths = [pipeline.make_agent(genome).body.max_diameter for genome in genomes]
    assert any(width > 0.026 for width in widths)
    for evaluation, width in zip(evaluations, widths, strict=True):
        if width > 0.026:
            assert f"{1000 * width:.4g} mm across, in a bore of 26 mm" in evaluation.failure
            assert evaluation.trajectory is None
        else:
            assert "too wide" not in (evaluation.failure or "")
