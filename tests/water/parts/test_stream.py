"""The mean flow in a pipe with parts: the free vortex, the area law, flux, divergence, joints."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from driftform.water import Scenario
from driftform.water.fittings import fitting_array
from driftform.water.parts.bends import crossing_potential, dean_cells, vortex_excess, vortex_strength
from driftform.water.parts.profiles import AT_A_POINT
from driftform.water.parts.shapes import Reducer, Straight
from driftform.water.parts.stream import fitting_flow, rise
from driftform.water.parts.walls import fitting_gap
from driftform.water.velocity import flow_array

R = 0.1
PARTS = [
    {"length": 0.5},
    {"kind": "bend", "radius": 0.3, "roll_deg": 90},
    {"length": 0.45},
    {"kind": "reducer", "length": 0.25, "radius": 0.06},
    {"length": 0.3},
    {"kind": "bend", "radius": 0.15, "angle_deg": 60, "roll_deg": 30},
    {"kind": "bend", "radius": 0.1, "angle_deg": 90, "roll_deg": 120},
    {"length": 0.1},
    {"kind": "reducer", "length": 0.2, "radius": 0.08},
    {"length": 1.0},
]
FLOWS = {
    "uniform": {"kind": "uniform", "speed": 1.3},
    "power": {"kind": "power_law", "speed": 1.3, "exponent": 7.0},
    "log": {"kind": "log_law", "speed": 1.3, "roughness": 0.0005},
    "swirl": {"kind": "log_law", "speed": 1.3, "roughness": 0.0005, "swirl": 0.2},
    "laminar": {"kind": "developed", "speed": 1.3},
}


def scenario_of(parts=PARTS, flow="uniform"):
    fluid = {"viscosity": 1e-3} if flow == "laminar" else {}
    return Scenario.model_validate({"pipe": {"radius": R, "parts": parts}, "flow": FLOWS[flow], "fluid": fluid})


class Water:
    """The mean flow of a scenario."""

    def __init__(self, scenario):
        self.f = fitting_array(scenario)

    def at(self, point):
        velocity, gradient = fitting_flow(tuple(map(float, point)), self.f, AT_A_POINT)
        return np.array(velocity), np.array(gradient)


def flux_through(water, centre, axes, radius, order=40):
    """The volume flow through a section of a bore, by Gauss's rule along the radius and equal steps around."""
    x, w = np.polynomial.legendre.leggauss(order)
    # With r = R (1 - s^2) the points crowd at the wall, where profiles are steep.
    s = 0.5 * (x + 1)
    r, weights = radius * (1 - s**2), w * radius * s * radius * (1 - s**2)
    angles = np.arange(4 * order) * 2 * np.pi / (4 * order)
    total = 0.0
    for a in angles:
        across = np.cos(a) * axes[1] + np.sin(a) * axes[2]
        total += sum(wi * (water.at(centre + ri * across)[0] @ axes[0]) for ri, wi in zip(r, weights, strict=True))
    return total * 2 * np.pi / len(angles)


def sections(part, count):
    """Centres, axes and radii of sections of a part."""
    [axis] = part.list_axes(part.length / (4 * count))
    along = np.gradient(axis.points, axis=0, edge_order=2)
    for k in np.linspace(1, len(axis.points) - 2, count).astype(int):
        x = along[k] / np.linalg.norm(along[k])
        y = part.axes[1]
        yield axis.points[k], np.stack([x, y, np.cross(x, y)]), axis.radii[k]


def test_a_bend_between_straights_has_the_free_vortex_with_the_flux_of_the_pipe():
    bend = {"kind": "bend", "radius": 3 * R, "angle_deg": 90}
    scenario = scenario_of([{"length": 0.5}, bend, {"length": 0.5}], "log")
    water, U = Water(scenario), 1.3
    part = scenario.pipe.layout.parts[1].part
    centre = part.origin + part.bend_radius * part.axes[2]
    Q = math.pi * R**2 * U
    K = Q / (2 * math.pi * (3 * R - math.sqrt(9 * R**2 - R**2)))
    for point, axes, _ in sections(part, 7):
        inward = (centre - point) / np.linalg.norm(centre - point)
        for share in (-0.999, 0.0, 0.5, 0.999):
            place = point + share * R * inward + 0.01 * R * axes[1]
            velocity, _ = water.at(place)
            distance = np.linalg.norm((place - centre) @ np.array([part.axes[0], part.axes[2]]).T)
            assert np.linalg.norm(velocity) == pytest.approx(K / distance, rel=1e-6)
            assert velocity @ part.axes[1] == pytest.approx(0, abs=1e-12)
        assert flux_through(water, point, axes, R) == pytest.approx(Q, rel=1e-9)
    # At R_c / a = 3 the speeds inside, on the axis and outside are 1.457, .971 and .729 of the mean.
    at_axis = np.linalg.norm(
        water.at(centre - 3 * R * part.axes[2] * math.cos(0.7) + 3 * R * part.axes[0] * math.sin(0.7))[0]
    )
    assert at_axis / U == pytest.approx(0.9714, abs=1e-4)


@given(st.floats(1.06, 50.0), st.floats(0, 0.999), st.floats(0, 2 * np.pi))
def test_the_flow_across_a_bore_takes_up_what_the_vortex_brings(tightness, share, angle):
    bend, U = tightness * R, 1.3
    xi, eta = share * R * math.cos(angle), share * R * math.sin(angle)
    h = 1e-6 * R

    def slope(x, y):
        return np.array(crossing_potential(x, y, bend, R, U)[0])

    hessian = np.column_stack(
        [(slope(xi + h, eta) - slope(xi - h, eta)) / (2 * h), (slope(xi, eta + h) - slope(xi, eta - h)) / (2 * h)]
    )
    D, _ = vortex_excess(xi, bend, R, U)
    _, (xx, xy) = crossing_potential(xi, eta, bend, R, U)
    # The differences of large logarithms in a wide bend leave some rounding.
    size = max(0.1, np.abs(hessian).max())
    assert hessian == pytest.approx(np.array([[xx, xy], [xy, D - xx]]), abs=1e-6 * size)
    wall = R * np.array([math.cos(angle), math.sin(angle)])
    assert wall @ slope(*wall) == pytest.approx(0, abs=1e-12)
    K, _ = vortex_strength(bend, R, U)
    assert K / (bend - xi) == pytest.approx(D + U)


def test_a_step_of_weights_is_smooth():
    for t in (0.0, 0.2, 0.7, 1.0):
        value, first, _ = rise(t)
        assert value == pytest.approx(quad(lambda x: rise(x)[1], 0, t)[0], abs=1e-12)
        assert first == pytest.approx(quad(lambda x: rise(x)[2], 0, t)[0], abs=1e-12)
    assert rise(-1.0) == (0.0, 0.0, 0.0) and rise(2.0) == (1.0, 0.0, 0.0)


@pytest.mark.parametrize("flow", FLOWS)
def test_every_section_has_the_flux_of_the_pipe(flow):
    scenario = scenario_of(flow=flow)
    water, Q = Water(scenario), math.pi * R**2 * 1.3
    for placed in scenario.pipe.layout.parts:
        for centre, axes, radius in sections(placed.part, 3):
            # A profile is constant within a thousandth of the radius from the wall, where its law is singular.
            close = 1e-9 if flow == "uniform" or not isinstance(placed.part, Straight) else 2e-3
            assert flux_through(water, centre, axes, radius, order=24) == pytest.approx(Q, rel=close)


@pytest.mark.parametrize("flow", FLOWS)
def test_the_gradient_is_that_of_the_velocity_and_has_no_trace(flow):
    scenario = scenario_of(flow=flow)
    water, rng, h = Water(scenario), np.random.default_rng(0), 1e-6
    for placed in scenario.pipe.layout.parts:
        for centre, axes, radius in sections(placed.part, 31):
            angle, share = rng.uniform(0, 2 * np.pi), math.sqrt(rng.uniform(0, 0.95))
            point = centre + share * radius * (math.cos(angle) * axes[1] + math.sin(angle) * axes[2])
            _, gradient = water.at(point)
            numeric = np.column_stack(
                [(water.at(point + h * e)[0] - water.at(point - h * e)[0]) / (2 * h) for e in np.eye(3)]
            )
            size = max(1.0, np.abs(gradient).max())
            assert np.trace(gradient) == pytest.approx(0, abs=1e-10 * size)
            if (
                not isinstance(placed.part, Reducer)
                or abs((point - placed.part.origin) @ axes[0] - placed.part.taper / 2) > 1e-5
            ):
                assert gradient == pytest.approx(numeric, abs=2e-4 * size)


@pytest.mark.parametrize("flow", FLOWS)
def test_the_water_flows_along_the_wall(flow):
    scenario = scenario_of(flow=flow)
    water, rng = Water(scenario), np.random.default_rng(1)
    for placed in scenario.pipe.layout.parts:
        for centre, axes, radius in sections(placed.part, 9):
            angle = rng.uniform(0, 2 * np.pi)
            wall = centre + (1 - 1e-9) * radius * (math.cos(angle) * axes[1] + math.sin(angle) * axes[2])
            _, normal, _ = fitting_gap(tuple(wall), water.f)
            velocity, _ = water.at(wall)
            assert velocity @ normal == pytest.approx(0, abs=3e-3 * 1.3 if flow != "uniform" else 1e-6)


@pytest.mark.parametrize("flow", FLOWS)
def test_the_velocity_goes_on_across_every_joint(flow):
    scenario = scenario_of(flow=flow)
    water, rng = Water(scenario), np.random.default_rng(2)
    inlet, parts = scenario.pipe.layout.inlet, scenario.pipe.layout.parts
    for opening in (inlet, *(o for placed in parts for o in placed.part.list_exits())):
        for _ in range(20):
            angle, share = rng.uniform(0, 2 * np.pi), math.sqrt(rng.uniform(0, 0.99))
            point = opening.centre + share * opening.radius * (
                math.cos(angle) * opening.axes[1] + math.sin(angle) * opening.axes[2]
            )
            before, after = (water.at(point + side * 1e-8 * opening.axes[0])[0] for side in (-1, 1))
            # At the end of a bend its secondary flow is no longer the narrower on the inside.
            assert after == pytest.approx(before, abs=1e-5 if flow != "swirl" else 0.25 * 0.2 * 1.3)


def test_the_secondary_flow_of_a_parabola_is_that_of_squire_and_winter():
    """laplacian(psi) = 2 theta du/d(eta), with u = 2 (1 - rho^2): the cells times theta are the flow of psi, at every point."""
    theta, a = 0.7, 0.4
    for xi, eta in ((0.0, 0.0), (0.1, -0.2), (-0.25, 0.15), (0.0, 0.4), (0.4, 0.0)):
        (u, v), (xx, xe, ex, ee) = dean_cells(xi, eta, a)
        assert theta * (xe - ex) == pytest.approx(-2 * theta * -4 * eta / a**2)
        assert xx + ee == 0.0
        if math.hypot(xi, eta) == pytest.approx(a):
            assert u * xi + v * eta == pytest.approx(0.0)
    assert dean_cells(0.0, 0.0, a)[0] == (-1.0, 0.0)


def test_the_secondary_flow_grows_in_a_bend_and_decays_behind_it():
    scenario = scenario_of([{"length": 0.5}, {"kind": "bend", "radius": 0.3}, {"length": 6.0}], "swirl")
    plain = scenario_of([{"length": 0.5}, {"kind": "bend", "radius": 0.3}, {"length": 6.0}], "log")
    exit_ = scenario.pipe.layout.parts[1].part.list_exits()[0]

    def swirl(point):
        return Water(scenario).at(point)[0] - Water(plain).at(point)[0]

    outward = -exit_.axes[2]
    assert swirl(exit_.centre) == pytest.approx(0.2 * 1.3 * outward, abs=1e-6)
    assert swirl(exit_.centre - 0.49 * np.pi * 0.3 * exit_.axes[0]) == pytest.approx(np.zeros(3), abs=2e-3)
    # A tenth of it is left after 15 diameters, and nothing where the straight ends.
    assert swirl(exit_.centre + 3.0 * exit_.axes[0]) @ outward == pytest.approx(0.1 * 0.2 * 1.3, rel=0.01)
    assert swirl(exit_.centre + 6.0 * exit_.axes[0]) == pytest.approx(np.zeros(3), abs=1e-9)
    # It returns along the sides of the bore, at twice the speed.
    side = exit_.centre + 0.999 * R * exit_.axes[1]
    assert swirl(side) @ outward == pytest.approx(-2 * 0.2 * 1.3, rel=0.02)


def test_a_reducer_speeds_the_water_up_by_the_area_law():
    scenario = scenario_of()
    water = Water(scenario)
    [reducer] = [placed.part for placed in scenario.pipe.layout.parts if isinstance(placed.part, Reducer)][:1]
    for x in (0.0, 0.1, 0.125, 0.2, 0.25):
        velocity, _ = water.at(reducer.origin + x * reducer.axes[0])
        radius = reducer.bore_radii(np.array([x]))[0]
        assert velocity @ reducer.axes[0] == pytest.approx(1.3 * (R / radius) ** 2)


def test_straights_far_from_fittings_carry_the_profile_of_a_straight_pipe():
    scenario = scenario_of([{"length": 2.0}, {"kind": "bend", "radius": 0.3}, {"length": 1.0}], "log")
    plain = Scenario.model_validate(
        {"pipe": {"segments": [{"start": [0, 0, 0], "end": [2.0, 0, 0], "radius": R}]}, "flow": FLOWS["log"]}
    )
    from driftform.water.velocity import pipe_rows, water_motion

    for y in (0.0, 0.03, 0.09):
        point = (1.0, y, 0.01)
        expected, gradient, _ = water_motion(point, 0.0, pipe_rows(plain), flow_array(plain))
        found = Water(scenario).at(point)
        assert found[0] == pytest.approx(np.array(expected), rel=1e-12)
        assert found[1] == pytest.approx(np.array(gradient), abs=1e-9)


def test_a_streamline_keeps_its_place_through_a_bend_between_straights():
    """By symmetry the water leaves a bend where it entered: what moves inward at its entry moves back at its end."""
    scenario = scenario_of([{"length": 0.5}, {"kind": "bend", "radius": 0.3}, {"length": 0.5}])
    water = Water(scenario)
    bend = scenario.pipe.layout.parts[1].part
    start = np.array([0.1, 0.0, 0.0])
    found = solve_ivp(lambda _, y: water.at(y)[0], (0, 2.0), start, rtol=1e-9, atol=1e-11, max_step=0.01)
    # Half way it has moved towards the bend's centre, by 3/8 of a^2 / R_c in a wide bend.
    local = bend.to_local(found.y.T)
    middle = np.argmin(np.abs(np.arctan2(local[:, 0], 0.3 - local[:, 2]) - np.pi / 4))
    moved = 0.3 - np.hypot(local[middle, 0], 0.3 - local[middle, 2]) - start[2]
    assert moved == pytest.approx(3 / 8 * R**2 / 0.3, rel=0.1)
    last = scenario.pipe.layout.parts[2].part.to_local(found.y.T)
    end = last[np.argmin(np.abs(last[:, 0] - 0.4))]
    assert end[1:] == pytest.approx(start[1:], abs=2e-4)


@pytest.mark.parametrize("flow", ["uniform", "log"])
def test_water_at_rest_stays_at_rest(flow):
    parts = [{"length": 0.5}, {"kind": "bend", "radius": 0.3}, {"length": 0.5}]
    speed = 0.0 if flow == "uniform" else 1e-4
    scenario = Scenario.model_validate({"pipe": {"radius": R, "parts": parts}, "flow": {**FLOWS[flow], "speed": speed}})
    velocity, gradient = Water(scenario).at((0.55, 0.0, 0.01))
    assert np.isfinite(gradient).all()
    assert np.linalg.norm(velocity) <= 1.5 * speed
