"""Contact with the walls of fittings: the deepest points of rims, flanks between them, and forces that keep the energy."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from solids import solid_agent

from driftform.motion.forces.bore import is_clear
from driftform.motion.forces.contact import deepest_depth
from driftform.motion.forces.fitting_contact import (
    FLATNESS,
    deepest_rim_point,
    flat_curvatures,
    flat_tilt,
    line_in_straight,
    rim_reach,
    touch_fitting,
)
from driftform.motion.forces.model import flight_model
from driftform.motion.forces.state import release_state
from driftform.motion.forces.surfaces import refined_surfaces, touching_surfaces
from driftform.motion.path.trajectory import energies
from driftform.motion.solver.error import Accuracy, integrate_once
from driftform.testing.bodies import cylinder_body, dome_body
from driftform.types import Coefficients
from driftform.water import Scenario
from driftform.water.fittings import wall_array
from driftform.water.parts.rows import greatest_curvature, rim_spacing
from driftform.water.parts.walls import fitting_gap

BEND = {"kind": "bend", "radius": 0.2, "angle_deg": 120}
TEE = {
    "kind": "tee",
    "branch_radius": 0.05,
    "fillet": 0.01,
    "share": 0.3,
    "outlet": "A",
    "branch": [{"length": 0.2, "outlet": "B"}],
}
PIPES = {
    "bend": [{"length": 0.3}, BEND, {"length": 0.3}],
    "reducer": [{"length": 0.3}, {"kind": "reducer", "length": 0.2, "radius": 0.05}, {"length": 0.3}],
    "tee": [{"length": 0.3}, TEE],
}


def still_scenario(parts, **release):
    tables = {
        "pipe": {"radius": 0.1, "parts": parts},
        "flow": {"speed": 0.0},
        "fluid": {"viscosity": 1e-8, "density": 1000.0, "gravity": 0.0},
        "contact": {"restitution": 1.0},
        "release": release,
        "flight": {"horizon": 3.0},
    }
    return Scenario.model_validate(tables)


def walls_of(scenario):
    """The array of a pipe in still water, whose flow needs no field."""
    return wall_array(scenario.pipe)


def agent_of(body):
    """A body of the water's density with the added mass of a body across."""
    return solid_agent(body, 1000.0, Coefficients(np.diag([0.01, 0.03, 0.03, 0.0, 1e-5, 1e-5])))


def rows_of(surfaces, scenario):
    """The surfaces of a model in a pipe, with what only friction asks for."""
    fall = (surfaces[:, 1] + surfaces[:, 2]) ** 2 * greatest_curvature(scenario.pipe.layout)
    return np.column_stack([surfaces, fall, np.ones(len(surfaces))])


def vector(values):
    return tuple(float(value) for value in values)


@pytest.mark.parametrize("name", PIPES)
def test_the_deepest_point_of_a_rim_is_that_of_many_points_around_it(name):
    scenario = still_scenario(PIPES[name])
    f, rng = walls_of(scenario), np.random.default_rng(0)
    angles, checked = np.linspace(0, 2 * np.pi, 2000, endpoint=False), 0
    for placed in scenario.pipe.layout.parts:
        for axis in placed.part.list_axes(0.01):
            for k in rng.integers(len(axis.points), size=40):
                r = float(rng.uniform(0.1, 0.5) * axis.radii[k])
                turned = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
                centre = axis.points[k] + rng.uniform(0.8, 1) * (axis.radii[k] - 0.6 * r) * turned[0]
                gap, normal, _ = fitting_gap(vector(centre), f)
                if gap > r or abs(normal @ turned[2]) > 0.99:
                    continue
                circle = centre + r * (np.cos(angles)[:, None] * turned[0] + np.sin(angles)[:, None] * turned[1])
                deepest = min(fitting_gap(vector(p), f)[0] for p in circle)
                surfaces = rows_of(np.array([[0.0, r, 0.0, 0.0, 0.0]]), scenario)
                depth, lever, wall, _, _ = touch_fitting(vector(centre), vector(turned[2]), surfaces, 0, f)
                tilted = math.sqrt(1 - (normal @ turned[2]) ** 2) > flat_tilt(r, surfaces, 0)
                if deepest > -0.01 * r and tilted:
                    assert depth == pytest.approx(-deepest, abs=2e-5 * r)
                if depth > 0 and tilted:
                    checked += 1
                    assert np.linalg.norm(lever) == pytest.approx(r, rel=1e-5)
                    assert np.cross(turned[2], lever) @ np.array(wall) == pytest.approx(0, abs=1e-5 * r)
    assert checked > 20


def test_a_rim_flat_against_the_wall_touches_with_its_centre():
    f = walls_of(still_scenario([{"length": 0.3}, BEND]))
    outward = np.array([math.sin(0.5), 0.0, -math.cos(0.5)])
    centre = np.array([0.3, 0.0, 0.2]) + 0.301 * outward
    flat = FLATNESS * 0.01 / 0.1
    gap, point, normal = deepest_rim_point(vector(centre), vector(outward), 0.01, flat, vector(outward), 0.0, f)
    assert normal == pytest.approx(outward, abs=1e-9)
    # The bore falls by r^2 / (2 R) within the rim.
    assert gap == pytest.approx(-0.001 - 0.5e-3, abs=0.0625e-3 + 1e-6)
    assert point == pytest.approx(centre, abs=1e-6)


@given(st.floats(1e-3, 0.05), st.floats(0.05, 1.0), st.floats(0.0, 1.0))
def test_the_depth_of_a_nearly_flat_rim_is_that_of_its_deepest_point_in_the_bore(r, R, c):
    reach, standoff = rim_reach(r, c, FLATNESS * r / R)
    # r c cos(a) + r^2 sin(a)^2 / (2 R), largest over a.
    true = r * c if c > r / R else r**2 / (2 * R) + c**2 * R / 2
    assert reach * c + standoff == pytest.approx(true, abs=r**2 / (16 * R) + 1e-12)


@given(st.floats(1e-3, 0.05), st.floats(0.01, 0.9), st.floats(0.0, 0.99))
def test_the_lever_of_a_nearly_flat_rim_is_the_derivative_of_its_depth(r, flat, t):
    def depth(c):
        reach, standoff = rim_reach(r, c, flat)
        return reach * c + standoff

    c, step = t * flat, 1e-6 * flat
    slope = (depth(c + step) - depth(max(0.0, c - step))) / (step + min(c, step))
    assert slope == pytest.approx(rim_reach(r, c, flat)[0], abs=1e-5 * r)
    along, across = flat_curvatures(r, c, flat)
    bend = (rim_reach(r, c + step, flat)[0] - rim_reach(r, c, flat)[0]) / step
    assert along == pytest.approx(bend, abs=1e-4 * r / flat)
    assert across * c == pytest.approx(rim_reach(r, c, flat)[0], abs=1e-9 * r)


@pytest.mark.parametrize("name", ["bend", "reducer"])
def test_a_nearly_flat_rim_is_pushed_as_its_depth_changes(name):
    """Otherwise a body that rocks on its end would gain energy."""
    scenario, rng, r = still_scenario(PIPES[name]), np.random.default_rng(3), 0.02
    flat = flat_tilt(r, rows_of(np.array([[0.0, r, 0.0, 0.0, 0.0]]), scenario), 0)
    f, [line] = walls_of(scenario), scenario.pipe.layout.parts[1].part.list_axes(0.01)

    def touch(centre, axis):
        _, normal, _ = fitting_gap(vector(centre), f)
        gap, point, wall = deepest_rim_point(vector(centre), vector(axis), r, flat, normal, 0.0, f)
        return -gap, np.array(point), np.array(wall)

    def slope(change):
        return np.array([(touch(*change(+1e-6 * e))[0] - touch(*change(-1e-6 * e))[0]) / 2e-6 for e in np.eye(3)])

    for k in rng.integers(2, len(line.points) - 2, size=60):
        along = line.points[k + 1] - line.points[k - 1]
        outward = np.cross(along, rng.standard_normal(3))
        centre = line.points[k] + (line.radii[k] - 0.004) * outward / np.linalg.norm(outward)
        _, normal, _ = fitting_gap(vector(centre), f)
        turn = np.cross(normal, rng.standard_normal(3))
        axis = Rotation.from_rotvec(rng.uniform(0, 0.35) * turn / np.linalg.norm(turn)).apply(normal)
        _, point, wall = touch(centre, axis)
        # To first order in the rim's radius over that of the bore, which is 0.2 to 0.4 here.
        assert slope(lambda d, c=centre, a=axis: (c + d, a)) == pytest.approx(wall, abs=0.06)
        torque = np.cross(point - centre, wall)
        found = slope(lambda d, c=centre, a=axis: (c, Rotation.from_rotvec(d).apply(a)))
        assert found == pytest.approx(torque - (torque @ axis) * axis, abs=0.1 * r)


def test_an_upright_body_slides_smoothly_along_the_crown_of_a_narrow_pipe():
    """Opposite points of its end share its load. A body that dropped it from one to the other was thrown off the wall."""
    tables = {
        "pipe": {"radius": 0.1, "parts": [{"length": 1.5}, BEND]},
        "flow": {"speed": 0.3},
        "contact": {"friction": 0.3},
        "release": {"position": (0.2, 0.0, 0.06), "pitch_deg": 90.0, "velocity": (0.3, 0.0, 0.0)},
        "flight": {"horizon": 3.0},
    }
    scenario = Scenario.model_validate(tables)
    coefficients = Coefficients(np.diag([0.01, 0.03, 0.03, 0.0, 1e-5, 1e-5]))
    model = flight_model(solid_agent(cylinder_body(0.06, 0.02), 900.0, coefficients), scenario)
    samples = integrate_once(model, release_state(model, scenario), 3.0, Accuracy())
    late = samples[samples[:, 0] > 2.0]
    assert late[-1, 0] == 3.0
    assert late[:, 3] == pytest.approx(np.full(len(late), late[-1, 3]), abs=2e-5)
    assert np.diff(late[:-1, 0]).min() > 1e-3


@pytest.mark.parametrize("make", [lambda: cylinder_body(0.1, 0.02), lambda: dome_body(0.03)])
def test_rims_are_added_until_no_flank_is_longer_than_the_spacing(make):
    body, spacing = make(), 0.004
    plain, refined = touching_surfaces(body), refined_surfaces(body, spacing)
    assert refined[: len(plain)] == pytest.approx(plain)
    rims = refined[refined[:, 2] == 0.0]
    domes = refined[refined[:, 2] > 0.0]
    # A dome ends in a rim of its own.
    ends = [(x + radius * s, radius * math.sqrt(1 - s * s), 0, 0, 0) for x, _, radius, *sines in domes for s in sines]
    rims = np.vstack([rims, *ends])
    # Every point of the contour is within half a spacing of a rim, or on a dome.
    outer = np.concatenate([np.linspace(a, b, 50) for a, b in zip(body.outer[:-1], body.outer[1:], strict=True)])
    for x, r in outer:
        near = np.hypot(rims[:, 0] - x, rims[:, 1] - r).min() if len(rims) else np.inf
        round_ = np.abs(np.hypot(domes[:, 0] - x, r) - domes[:, 2]).min() if len(domes) else np.inf
        assert near <= 0.51 * spacing or round_ < 1e-4


def test_the_spacing_of_rims_follows_the_sharpest_bulge():
    def spacing(parts):
        return rim_spacing(still_scenario(parts).pipe.layout)

    assert spacing(PIPES["bend"]) == pytest.approx(math.sqrt(8 * 2e-4 * 0.1))
    assert spacing(PIPES["tee"]) == pytest.approx(math.sqrt(8 * 2e-4 * 0.01))


def test_a_flank_touches_the_inside_of_a_bend_between_its_corners():
    scenario = still_scenario(PIPES["bend"])
    f, body = walls_of(scenario), cylinder_body(0.16, 0.01)
    inward = np.array([-math.sin(1.0), 0.0, math.cos(1.0)])
    along = np.array([math.cos(1.0), 0.0, math.sin(1.0)])
    # Its middle lies half a millimetre deep in the wall on the inside of the bend, and its ends are clear.
    middle = np.array([0.3, 0.0, 0.2]) - (0.1 + 0.01 - 5e-4) * inward
    model = flight_model(agent_of(body), still_scenario([{"length": 1.0}]))
    y = np.array([0.0, 1.0, 0.0])
    R = tuple(vector(row) for row in np.column_stack([along, y, np.cross(along, y)]))
    rows = rows_of(refined_surfaces(body, rim_spacing(scenario.pipe.layout)), scenario)
    found = deepest_depth(vector(middle), R, model._replace(surfaces=rows, fittings=f))
    assert 3e-4 <= found <= 5e-4
    few = rows_of(touching_surfaces(body), scenario)
    assert deepest_depth(vector(middle), R, model._replace(surfaces=few, fittings=f)) == 0.0


def test_a_surface_that_is_clear_of_a_straight_touches_no_part():
    scenario, rng, clear = still_scenario(PIPES["tee"]), np.random.default_rng(0), 0
    f = walls_of(scenario)
    rows = rows_of(refined_surfaces(cylinder_body(0.05, 0.015), rim_spacing(scenario.pipe.layout)), scenario)
    reach = 0.05
    for _ in range(300):
        axis = rng.normal(size=3)
        axis = vector(axis / np.linalg.norm(axis))
        place = vector(np.array([rng.uniform(0.0, 0.3), *rng.uniform(-0.1, 0.1, 2)]))
        line = line_in_straight(place, axis, reach, f)
        for k in range(len(rows)):
            if is_clear(rows, k, line):
                clear += 1
                assert touch_fitting(place, axis, rows, k, f)[0] <= 0.0
    assert clear > 100


@pytest.mark.long
@pytest.mark.parametrize("name", PIPES)
@pytest.mark.parametrize("make", [lambda: cylinder_body(0.05, 0.015), lambda: dome_body(0.02)])
def test_a_body_that_bounces_without_loss_keeps_its_energy_and_stays_inside(name, make):
    scenario = still_scenario(
        PIPES[name], position=[0.25, 0.01, 0.02], pitch_deg=-20.0, yaw_deg=15.0, velocity=[0.5, 0.11, 0.23]
    )
    agent = agent_of(make())
    open_model = flight_model(agent, still_scenario([{"length": 1.0}]))
    spacing = rim_spacing(scenario.pipe.layout)
    rows = rows_of(refined_surfaces(agent.body, spacing), scenario)
    model = open_model._replace(
        surfaces=rows, touches=np.zeros((len(rows) + 1, 10)), fittings=walls_of(scenario), pipe=np.empty((0, 8))
    )
    start = release_state(open_model, scenario)
    start[10:] = (3.0, 1.0, -2.0)
    samples = integrate_once(model, start, 3.0, Accuracy(tolerance=1e-9, max_step=0.01))
    clear, touching, deepest = [], 0, 0.0
    for row in samples:
        w, x, y, z = row[4:8]
        R = Rotation.from_quat([x, y, z, w]).as_matrix()
        depth = deepest_depth(vector(row[1:4]), tuple(vector(r) for r in R), model)
        touching += depth > 0
        deepest = max(deepest, depth)
        if depth == 0.0:
            clear.append(sum(energies(row, model)))
    assert touching > 20
    assert deepest < 1e-3
    assert np.ptp(clear) < 0.01 * np.mean(clear)
