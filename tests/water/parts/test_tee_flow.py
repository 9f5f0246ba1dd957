"""The ideal flow in tees, against what holds for every potential flow, and against tracers that it carries."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from driftform.util.compiled import compiled
from driftform.water.parts.tee_flow import tee_field, tee_motion
from driftform.water.parts.tee_store import JUNCTIONS, PACKAGED, file_name
from driftform.water.parts.tee_wall import Junction, wall_level
from driftform_tees.region import distance_beyond_ends

WYES = ((0.7, 45, 0.14), (0.7, 60, 0.14), (1.0, 45, 0.2))
SHAPES = (*JUNCTIONS, *(Junction(branch, math.radians(angle), fillet) for branch, angle, fillet in WYES))
SHARES = (0.1, 0.3, 0.5, 0.7, 0.9)

LEG = 2.0
"""Radii beyond the rounded edge at which the parts of a pipe end."""


def make_field(junction, share):
    """The flow at a mean speed of 1 m/s through a run of 1 m radius."""
    return tee_field(1.0, junction.branch, junction.angle, junction.fillet, math.pi * (1 - share), math.pi * share)


def end_planes(junction):
    """x of the inlet and of the outlet of the part, and the end of its branch from the origin, m."""
    c, s, f = math.cos(junction.angle), math.sin(junction.angle), junction.fillet
    rho = junction.branch + f
    return (((1 + f) * c - rho) / s - LEG, ((1 + f) * c + rho) / s + LEG, (1 + f + rho * c) / s + LEG * junction.branch)


@cache
def water_points(junction, count=400):
    """Random points of the water, half of them near the rounded edge."""
    rng, wall, found = np.random.default_rng(5), junction.array(), []
    left, right, end = end_planes(junction)
    while len(found) < count:
        x, y, z = rng.uniform([left, -1, -1], [right, 1, end])
        if len(found) % 2 and abs(wall_level(x, y, z, wall)[0]) > junction.fillet:
            continue
        # Beyond its ends a part has no water, though the flow that is stored reaches a little farther.
        is_inside = math.hypot(y, z) < 1 or x * math.cos(junction.angle) + z * math.sin(junction.angle) < end
        if is_inside and wall_level(x, y, z, wall)[0] < -0.01 and distance_beyond_ends(x, y, z, wall) < -0.05:
            found.append((x, y, z))
    return np.array(found)


def draw_disc(count, seed=0):
    """Points and weights of Gauss's rule over a unit disc."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    angle = 2 * np.pi * np.arange(4 * count) / (4 * count)
    r = (nodes + 1) / 2
    points = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))], axis=-1).reshape(-1, 2)
    return points, np.repeat(r * weights / 2, 4 * count) * 2 * np.pi / (4 * count)


@compiled
def advance(x, step, field):
    """One step of Runge and Kutta's classical method of about this length, m."""
    v, _ = tee_motion(x, field)
    h = step / max(0.2, math.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2))
    a, _ = tee_motion((x[0] + h / 2 * v[0], x[1] + h / 2 * v[1], x[2] + h / 2 * v[2]), field)
    b, _ = tee_motion((x[0] + h / 2 * a[0], x[1] + h / 2 * a[1], x[2] + h / 2 * a[2]), field)
    c, _ = tee_motion((x[0] + h * b[0], x[1] + h * b[1], x[2] + h * b[2]), field)
    return (
        x[0] + h / 6 * (v[0] + 2 * a[0] + 2 * b[0] + c[0]),
        x[1] + h / 6 * (v[1] + 2 * a[1] + 2 * b[1] + c[1]),
        x[2] + h / 6 * (v[2] + 2 * a[2] + 2 * b[2] + c[2]),
    )


@compiled
def enters_branch(y, z, start, outlet, end, cosine, sine, field):
    """Return True if a tracer that starts at y, z of the inlet leaves by the branch."""
    x = (start, y, z)
    for _ in range(30_000):
        x = advance(x, 0.02, field)
        if x[0] > outlet:
            return False
        if x[0] * cosine + x[2] * sine > end and x[1] * x[1] + x[2] * x[2] > 1.0:
            return True
    return False


def branch_share(junction, share, lines=24):
    """The share of the inlet's flux whose tracers leave by the branch, by the surface that divides them."""
    field = make_field(junction, share)
    start, outlet, end = end_planes(junction)
    rest = (start, outlet, end, math.cos(junction.angle), math.sin(junction.angle), field)
    nodes, weights = np.polynomial.legendre.leggauss(lines)
    angle = np.pi / 4 * (nodes + 1)
    total = 0.0
    for y, weight in zip(np.sin(angle), np.cos(angle) * weights * np.pi / 4, strict=True):
        top = math.sqrt(1 - y * y)
        low, high = -top, top
        for _ in range(13):
            middle = 0.5 * (low + high)
            if enters_branch(y, middle, *rest):
                high = middle
            else:
                low = middle
        total += weight * (top - 0.5 * (low + high))
    return total / (np.pi / 2)


@pytest.mark.long
@pytest.mark.parametrize("junction", SHAPES)
@pytest.mark.parametrize("share", SHARES)
def test_tracers_enter_the_branch_in_the_ratio_of_the_fluxes(junction, share):
    off = 0.2 if junction.branch >= 0.5 else 0.35
    assert 100 * branch_share(junction, share) == pytest.approx(100 * share, abs=off)


@pytest.mark.parametrize("junction", SHAPES)
@pytest.mark.parametrize("share", (0.0, *SHARES))
def test_the_wall_leaks_less_than_two_thousandths_of_the_mean_speed(junction, share):
    # The root mean square over the walls of both legs, relative to the mean speed at the inlet; of narrower branches than half of
    # the run, which may have many times its speed, to a quarter of the mean speed there if that is more.
    wall, field, most = junction.array(), make_field(junction, share), max(1.0, share / (2 * junction.branch) ** 2)
    start, outlet, end = end_planes(junction)
    turn, along = (part.ravel() for part in np.meshgrid(np.linspace(0, 2 * np.pi, 49)[1:], (np.arange(64) + 0.5) / 64))
    c, s, r = math.cos(junction.angle), math.sin(junction.angle), junction.branch
    far, out, side = end * along, r * np.cos(turn), r * np.sin(turn)
    legs = (
        (np.column_stack([start + (outlet - start) * along, np.sin(turn), np.cos(turn)]), outlet - start),
        (np.column_stack([far * c - out * s, side, far * s + out * c]), r * end),
    )
    total = area = 0.0
    for points, size in legs:
        for point in points.tolist():
            level, normal = wall_level(*point, wall)
            if abs(level) < 1e-9:
                total, area = total + size * np.dot(tee_motion(tuple(point), field)[0], normal) ** 2, area + size
    assert math.sqrt(total / area) < 0.002 * most
    # And at random points of the rounded edge and near it, where the water is fastest.
    squares = []
    for point in water_points(junction):
        level, normal = wall_level(*point, wall)
        if level > -junction.fillet:
            foot = point - level * np.array(normal)
            squares.append(np.dot(tee_motion(tuple(foot), field)[0], normal) ** 2)
    assert len(squares) > 50
    assert math.sqrt(np.mean(squares)) < 0.02


@pytest.mark.parametrize("junction", SHAPES)
@pytest.mark.parametrize("share", (0.0, 0.3, 1.0))
def test_the_flux_is_that_of_each_leg_at_every_section(junction, share):
    field, (disc, weight) = make_field(junction, share), draw_disc(24)
    left, right, end = end_planes(junction)
    c, s, r = math.cos(junction.angle), math.sin(junction.angle), junction.branch

    def run_flux(x):
        return float(sum(w * tee_motion((x, y, z), field)[0][0] for (y, z), w in zip(disc, weight, strict=True)))

    # Cells of 0.37, those of the branch of 0.7, resolve less than those of 0.27.
    off = 3e-4 if junction.width < 0.3 else 5e-4
    for x in np.linspace(left, left + LEG, 4):
        assert run_flux(x) / np.pi == pytest.approx(1, abs=off)
    for x in np.linspace(right - LEG, right, 4):
        assert run_flux(x) / np.pi == pytest.approx(1 - share, abs=off)
    for t in np.linspace(end - LEG * r, end, 4):
        flux = 0.0
        for (y, up), w in zip(r * disc, r * r * weight, strict=True):
            u, _, v = tee_motion((t * c + up * s, y, t * s - up * c), field)[0]
            flux += w * (u * c + v * s)
        assert flux / np.pi == pytest.approx(share, abs=off)


@pytest.mark.parametrize("junction", SHAPES)
def test_the_gradient_is_that_of_the_velocity_symmetric_and_almost_without_trace(junction):
    field, h = make_field(junction, 0.4), 1e-5
    traces, sizes = [], []
    for point in water_points(junction):
        gradient = np.array(tee_motion(tuple(point), field)[1])
        slopes = [
            np.subtract(tee_motion(tuple(point + h * e), field)[0], tee_motion(tuple(point - h * e), field)[0])
            / (2 * h)
            for e in np.eye(3)
        ]
        assert np.transpose(slopes) == pytest.approx(gradient, abs=1e-4 * (1 + np.abs(gradient).max()))
        assert np.array_equal(gradient, gradient.T)
        traces.append(np.trace(gradient))
        sizes.append(np.linalg.norm(gradient))
    # The splines solve Laplace's equation in the mean over a cell.
    assert np.sqrt(np.mean(np.square(traces))) < 0.05 * np.sqrt(np.mean(np.square(sizes)))


@pytest.mark.parametrize("junction", SHAPES)
def test_the_flow_decays_to_plug_flow_as_the_slowest_mode_of_a_pipe(junction):
    # J_1'(1.8412) = 0 and J_2'(3.0542) = 0: Abramowitz and Stegun, table 9.5. Near the tee the second mode takes part.
    field, (disc, _) = make_field(junction, 0.4), draw_disc(6)
    left, right, _ = end_planes(junction)

    def deviation(x, mean):
        return max(float(np.linalg.norm(np.subtract(tee_motion((x, y, z), field)[0], (mean, 0, 0)))) for y, z in disc)

    upstream = [deviation(left + d, 1.0) for d in (1.0, 0.5)]
    assert 0.9 * 1.8412 < math.log(upstream[0] / upstream[1]) / 0.5 < 3.0542
    assert deviation(left, 1.0) < 0.02
    assert deviation(right, 0.6) < 0.02


@settings(max_examples=300)
@given(number=st.integers(0, len(JUNCTIONS) - 1), place=st.tuples(*[st.floats(-1.0, 1.0)] * 3), share=st.floats(0, 1))
@example(number=0, place=(-1.0, 0.0, 1.0), share=0.0)
@example(number=2, place=(0.0, 1.0, 0.0), share=0.0)
def test_the_velocity_is_finite_and_continuous_in_the_wall_and_beyond_the_ends(number, place, share):
    field = make_field(JUNCTIONS[number], 0.3)
    point = np.array(place) * [8, 1.5, 8]
    velocity, gradient = tee_motion(tuple(point), field)
    assert np.isfinite(velocity).all() and np.isfinite(gradient).all()
    # A body's centre is never deeper in the wall than its contact, far below this.
    if wall_level(*point, JUNCTIONS[number].array())[0] < 0.01:
        beside = tee_motion(tuple(point + 1e-7), field)[0]
        assert np.abs(np.subtract(beside, velocity)).max() < 1e-4


def test_the_flows_of_usual_shapes_come_with_driftform():
    assert all((PACKAGED / file_name(shape)).is_file() for shape in SHAPES)


def test_a_branch_that_points_upstream_is_the_mirror_image_of_a_reversed_flow():
    behind = tee_field(0.1, 0.05, math.radians(120), 0.01, 0.002, 0.001)
    # 3 l/s enter the mirror image where its run would end; 2 leave where it would begin.
    image = tee_field(0.1, 0.05, math.radians(60), 0.01, -0.003, 0.001)
    for x, y, z in 0.1 * water_points(JUNCTIONS[0], 50):
        u, v, w = tee_motion((x, y, z), image)[0]
        assert tee_motion((-x, y, z), behind)[0] == pytest.approx((-u, v, w), abs=1e-12)


def test_the_speed_scales_with_the_flow_and_the_field_with_the_radius():
    small = tee_field(0.1, 0.05, math.pi / 2, 0.01, 0.002, 0.001)
    large = tee_field(1.0, 0.5, math.pi / 2, 0.1, 0.2, 0.1)
    for x, y, z in water_points(JUNCTIONS[1], 20):
        velocity, gradient = tee_motion((0.1 * x, 0.1 * y, 0.1 * z), small)
        velocity_1, gradient_1 = tee_motion((x, y, z), large)
        assert velocity == pytest.approx(velocity_1, rel=1e-9)
        assert np.array(gradient) == pytest.approx(10 * np.array(gradient_1), rel=1e-9)


@pytest.mark.parametrize("shares, lightest", [(0.05, 0.0067), (0.1, 0.0187), (0.2, 0.052), (0.3, 0.094)])
def test_a_small_share_of_the_water_comes_from_near_the_wall(shares, lightest):
    # A sphere of ``shares`` times the radius of the run, with its centre that far from the wall, cannot enter while
    # the branch takes less water than flows past between the centre and the wall (flat dividing surface).
    junction = JUNCTIONS[1]
    start, outlet, end = end_planes(junction)
    ways = []
    for share in (0.7 * lightest, 1.3 * lightest):
        field = make_field(junction, share)
        ways.append(enters_branch(0.0, 1 - shares, start, outlet, end, 0.0, 1.0, field))
    assert ways == [False, True]


@pytest.mark.parametrize(
    "shape, words",
    [
        ((1.0, 1.2, 1.5, 0.2), "between|from 0.2 to 1"),
        ((1.0, 0.5, 0.3, 0.1), "from 30 to 150 degrees"),
        ((1.0, 0.5, 1.5, 0.0), "sharp edge"),
    ],
)
def test_shapes_without_a_known_flow_are_refused(shape, words):
    with pytest.raises(ValueError, match=words):
        tee_field(*shape, 1.0, 0.0)
