"""A study's speed is the mean over the wetted section, and a surface where the flow is not known is refused."""

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.study import load_study
from driftform.water import Scenario
from driftform.water.field import water_velocity
from driftform.water.wetted import find_surface_fault

RADIUS, SPEED = 0.2, 0.7
FLOWS = [
    {"kind": "log_law", "roughness": 1e-4},
    {"kind": "power_law", "exponent": 7.0},
    {"kind": "developed"},
    {"kind": "developing"},
]


def half_full(level, start_z=0.0, **flow):
    return Scenario.model_validate(
        {
            "pipe": {"segments": [{"start": [0, 0, start_z], "end": [6, 0, 0], "radius": RADIUS}]},
            "flow": {"speed": SPEED, **flow},
            "fluid": {"water_level": level},
            "release": {"position": [0, 0, -0.9 * RADIUS]},
        }
    )


def mean_below(scenario, height):
    """The mean speed half-way along the pipe, over the cells of a fine square grid that lie below a height."""
    y = RADIUS * (np.arange(800) + 0.5 - 400) / 400
    Y, Z = (a.ravel() for a in np.meshgrid(y, y))
    wet = (np.hypot(Y, Z) < RADIUS) & (height > Z)
    points = np.stack([np.full(wet.sum(), 3.0), Y[wet], Z[wet]], axis=1)
    return float(water_velocity(points, 0.0, scenario)[:, 0].mean())


@pytest.mark.parametrize("share", [-0.8, 0.0, 0.5])
@pytest.mark.parametrize("flow", FLOWS, ids=lambda flow: flow["kind"])
def test_the_mean_over_the_wetted_section_is_the_speed_of_the_study(flow, share):
    height = share * RADIUS
    assert mean_below(half_full(height, **flow), height) == pytest.approx(SPEED, rel=2e-3)


def test_a_surface_above_the_bore_or_below_it_changes_nothing():
    flow = FLOWS[0]
    full = water_velocity([[3.0, 0.0, 0.1]], 0.0, half_full(None, **flow))
    assert (water_velocity([[3.0, 0.0, 0.1]], 0.0, half_full(RADIUS, **flow)) == full).all()


def test_a_surface_in_a_pipe_with_a_slope_is_refused():
    with pytest.raises(ValueError, match="cuts a pipe with a slope, whose bore reaches"):
        half_full(0.0, 0.06, kind="log_law")


def test_a_surface_that_cuts_a_junction_is_refused_in_one_line():
    with pytest.raises(InputError) as caught:
        load_study("t-junction", ["fluid.water_level=0.02"])
    [line] = caught.value.args
    assert "fluid.water_level = 0.02 cuts a pipe with parts, whose bore reaches from z " in line


def test_the_bore_of_a_sloping_pipe_reaches_as_far_as_its_rims():
    """Its axis rises 3 in 5 m, so that the rims at the ends lie 4/5 of the radius below and above the axis."""
    pipe = Scenario.model_validate({"pipe": {"segments": [{"start": [0, 0, 0], "end": [4, 0, 3], "radius": 0.5}]}}).pipe
    flow = half_full(None, kind="developed").flow
    faults = [find_surface_fault(pipe, flow, level) for level in (-0.41, -0.39, 3.39, 3.41)]
    assert [fault is None for fault in faults] == [True, False, False, True]
