"""Velocities of the water and distances from the wall at points of the world, against closed forms."""

import math

import numpy as np
import pytest

from driftform.motion.forces.model import flight_model
from driftform.motion.forces.state import release_state
from driftform.testing.agents import sphere_agent
from driftform.water import Scenario
from driftform.water.field import wall_distance, water_velocity
from driftform.water.scenario import Release

R = 0.1


def scenario_of(parts, **tables):
    return Scenario.model_validate({"pipe": {"radius": R, "parts": parts}, **tables})


def straight(**tables):
    segment = {"start": (1.0, 0.0, 0.5), "end": (4.0, 0.0, 4.5), "radius": 0.2}
    return Scenario.model_validate({"pipe": {"segments": [segment]}, **tables})


AXIS, ACROSS = np.array([0.6, 0.0, 0.8]), np.array([0.8, 0.0, -0.6])


def place(along, off):
    """A point of the inclined straight pipe, ``off`` (m) from its axis."""
    return np.array([1.0, 0.0, 0.5]) + along * AXIS + off * ACROSS


def test_the_distance_in_a_straight_pipe_is_the_radius_less_that_from_the_axis():
    points = [place(1.0, 0.0), place(2.0, 0.15), place(2.5, 0.2), place(3.0, 0.26), place(-0.5, 0.1)]
    assert wall_distance(points, straight()) == pytest.approx([0.2, 0.05, 0.0, -0.06, 0.1], abs=1e-12)


def test_open_water_has_no_wall():
    assert np.isposinf(wall_distance(np.zeros((3, 3)), Scenario())).all()


def test_the_distance_in_a_bend_is_that_in_a_torus():
    scenario = scenario_of([{"length": 0.5}, {"kind": "bend", "radius": 0.3, "roll_deg": 90}, {"length": 0.5}])
    # The pipe turns right, towards -y, about a point beside the bend's entry.
    rng = np.random.default_rng(1)
    turn, far, z = rng.uniform(0.1, 1.4, 50), rng.uniform(0.21, 0.39, 50), rng.uniform(-0.09, 0.09, 50)
    points = np.column_stack([0.5 + far * np.sin(turn), -0.3 + far * np.cos(turn), z])
    expected = R - np.hypot(far - 0.3, z)
    assert wall_distance(points, scenario) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("end", [0.06, 0.14])
def test_the_distance_in_a_reducer_is_that_from_its_arcs(end):
    scenario = scenario_of([{"kind": "reducer", "length": 0.4, "radius": end}, {"length": 0.5}])
    # The early arc begins along the axis at the entry, the late one ends along it; the wider half is hollow.
    change = R - end
    arc = math.copysign((0.4**2 + change**2) / (4 * abs(change)), change)
    early, late = np.array([0.0, R - arc]), np.array([0.4, end + arc])
    points = np.array(
        [[0.1, 0.03, 0.0], [0.05, 0.05, 0.05], [0.12, 0.0, -0.08], [0.32, 0.05, 0.0], [0.35, 0.03, -0.045]]
    )
    meridian = np.column_stack([points[:, 0], np.hypot(points[:, 1], points[:, 2])])
    away = np.linalg.norm(meridian - np.where(points[:, :1] < 0.2, early, late), axis=1)
    expected = np.where(points[:, 0] < 0.2, 1, -1) * (arc - math.copysign(1, arc) * away)
    assert wall_distance(points, scenario) == pytest.approx(expected, abs=1e-12)


def test_a_grid_has_the_velocity_of_its_file(tmp_path):
    file = tmp_path / "shear.csv"
    nodes = np.stack(np.meshgrid(*[np.arange(5.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    rows = [f"{x},{y},{z},{1 + 0.1 * z},{0.2 * x},0" for x, y, z in nodes]
    file.write_text("x,y,z,u,v,w\n" + "\n".join(rows))
    scenario = Scenario(flow={"kind": "grid", "file": str(file), "speed": 2.0, "reference": 1.0})
    nodes = np.array([[2.0, 1.0, 2.0], [1.0, 3.0, 2.0]])
    expected = 2.0 * np.array([[1.2, 0.4, 0.0], [1.2, 0.2, 0.0]])
    assert water_velocity(nodes, 0.0, scenario) == pytest.approx(expected, abs=1e-9)


def test_gusts_are_left_out_unless_they_are_asked_for():
    flow = {"speed": 1.3, "roughness": 2e-4}
    calm = straight(flow={"kind": "log_law", **flow})
    windy = straight(flow={"kind": "turbulent", **flow}, gusts={"seed": 3})
    points, t = np.array([place(1.0, 0.1), place(2.0, 0.0)]), np.array([0.4, 3.0])
    mean = water_velocity(points, 0.0, calm)
    np.testing.assert_array_equal(water_velocity(points, t, windy), mean)
    found = water_velocity(points, t, windy, gusts=True)
    # At the release, tau is zero everywhere: the gust of any body is that of a tracer.
    start = water_velocity(points, 0.0, windy, gusts=True)
    for point, velocity in zip(points.tolist(), start, strict=True):
        moved = windy.model_copy(update={"release": Release(position=tuple(point), frame="world")})
        model = flight_model(sphere_agent(1e-6, 4e-15), moved)
        assert release_state(model, moved)[7:10] == pytest.approx(velocity, abs=1e-6)
    assert 0 < np.abs(found - mean).max() < 0.5
