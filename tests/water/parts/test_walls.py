"""The wall of a pipe with parts: distances against independent ones, normals, joints, and the test that a body is clear."""

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from driftform.water import Pipe
from driftform.water.fittings import wall_array
from driftform.water.parts.rows import wall_rows
from driftform.water.parts.shapes import Bend, Reducer, Tee
from driftform.water.parts.walls import HEAD, fitting_gap, is_far_in_fittings

RUN, BRANCH = 0.1, 0.05
WINDING = Pipe.model_validate(
    {
        "radius": RUN,
        "start": [0.3, -0.2, 0.1],
        "direction": [2.0, 1.0, -1.0],
        "parts": [
            {"length": 0.4},
            {"kind": "bend", "radius": 0.25, "angle_deg": 70, "roll_deg": 100},
            {"kind": "reducer", "length": 0.2, "radius": 0.07},
            {"kind": "bend", "radius": 0.08, "angle_deg": 120, "roll_deg": 30},
            {"kind": "reducer", "length": 0.3, "radius": 0.12},
            {
                "kind": "wye",
                "branch_radius": BRANCH,
                "share": 0.3,
                "roll_deg": 200,
                "branch": [{"kind": "bend", "radius": 0.1, "roll_deg": 180, "angle_deg": 60, "outlet": "B"}],
            },
            {"length": 0.3, "outlet": "A"},
        ],
    }
)


def gap(point, f):
    distance, normal, _ = fitting_gap(tuple(map(float, point)), f)
    return distance, np.array(normal)


def make_wye(ratio, degrees, fillet):
    parts = [
        {
            "kind": "wye",
            "angle_deg": degrees,
            "branch_radius": ratio * RUN,
            "fillet": fillet * ratio * RUN,
            "share": 0.3,
            "outlet": "A",
            "branch": [{"length": 0.2, "outlet": "B"}],
        }
    ]
    return Pipe.model_validate({"radius": RUN, "parts": parts})


def beyond_bores(tee, p):
    """How far points lie beyond the run and the branch of a tee, m."""
    c, s = math.cos(tee.angle), math.sin(tee.angle)
    along = c * p[:, 0] + s * p[:, 2]
    branch = np.hypot(p[:, 1], c * p[:, 2] - s * p[:, 0]) - tee.branch_radius
    return np.hypot(p[:, 1], p[:, 2]) - tee.radius, np.where(along >= 0, branch, np.inf)


def distance_by_rolling_ball(tee, p):
    """Distances of points of the local frame from the wall, by definition: from the centres of all balls in the wall, less their radius.

    These centres lie at least a fillet beyond both bores; the nearest is on one of the two cylinders that bound them.
    """
    up, down, side = tee.legs
    f, angle = tee.fillet, np.linspace(0, 2 * np.pi, 721)
    x, phi = np.meshgrid(np.linspace(-up, down, 500), angle)
    r = tee.radius + f
    run = np.stack([x, r * np.cos(phi), r * np.sin(phi)], axis=-1).reshape(-1, 3)
    run = run[beyond_bores(tee, run)[1] >= f]
    t, phi = np.meshgrid(np.linspace(0, side, 500), angle)
    r, c, s = tee.branch_radius + f, math.cos(tee.angle), math.sin(tee.angle)
    u, v = r * np.cos(phi), r * np.sin(phi)
    branch = np.stack([t * c + u * s, v, t * s - u * c], axis=-1).reshape(-1, 3)
    branch = branch[beyond_bores(tee, branch)[0] >= f]
    return cKDTree(np.concatenate([run, branch])).query(p)[0] - f


@pytest.mark.parametrize(
    ("ratio", "degrees", "fillet"),
    [(0.5, 90, 0.2), (1.0, 90, 0.1), (0.5, 60, 0.2), (1.0, 60, 0.2), (0.7, 45, 0.5), (0.5, 120, 0.1), (1.0, 30, 0.2)],
)
def test_the_gap_in_a_tee_is_the_distance_from_balls_that_roll_in_its_wall(ratio, degrees, fillet):
    pipe = make_wye(ratio, degrees, fillet)
    [tee, _] = [placed.part for placed in pipe.layout.parts]
    f, rng = wall_array(pipe), np.random.default_rng(0)
    up, down, side = tee.legs
    p = rng.uniform([-up, -RUN - 0.002, -RUN - 0.002], [down, RUN + 0.002, side * math.sin(tee.angle)], (12_000, 3))
    a, b = beyond_bores(tee, p)
    along = p @ [math.cos(tee.angle), 0, math.sin(tee.angle)]
    near = (np.abs(np.minimum(a, b) + 0.3 * BRANCH) < 0.3 * BRANCH + 0.002) & (along < side - tee.branch_radius)
    p = p[near & (p[:, 0] > -up + RUN) & ((p[:, 0] < down - RUN) | (b < 0))]
    expected = distance_by_rolling_ball(tee, p)
    # The deep end of a ball is no wall that anything reaches.
    p, expected = p[expected > -0.5 * tee.fillet], expected[expected > -0.5 * tee.fillet]
    found = np.array([gap(w, f)[0] for w in tee.to_world(p)])
    assert len(p) > 1000
    # Sampled distances are too large, by the square of the spacing.
    assert (expected - found).min() > -1e-8
    assert (expected - found).max() < 4e-4
    assert np.median(expected - found) < 2e-5


def test_the_normal_is_the_direction_in_which_the_gap_falls_fastest():
    f, rng, h = wall_array(WINDING), np.random.default_rng(2), 1e-6
    checked = 0
    for placed in WINDING.layout.parts:
        for axis in placed.part.list_axes(0.01):
            for k in rng.integers(1, len(axis.points) - 1, 25):
                out = rng.normal(size=3)
                p = axis.points[k] + 0.93 * axis.radii[k] * out / np.linalg.norm(out)
                g, n = gap(p, f)
                slope = np.array([gap(p + h * e, f)[0] - gap(p - h * e, f)[0] for e in np.eye(3)]) / (2 * h)
                if 0 < g < 0.3 * placed.part.radius:
                    assert np.linalg.norm(n) == pytest.approx(1.0)
                    # Between two walls at the same distance the slope is that of neither.
                    checked += slope == pytest.approx(-n, abs=1e-4)
    assert checked > 120


def test_gap_and_normal_go_on_across_joints_also_in_the_wall():
    f, rng = wall_array(WINDING), np.random.default_rng(3)
    for placed in WINDING.layout.parts:
        for opening in placed.part.list_exits():
            for _ in range(40):
                angle, share = rng.uniform(0, 2 * np.pi), rng.choice([0.3, 0.9, 1.0, 1.02])
                across = np.array([0.0, math.cos(angle), math.sin(angle)]) @ opening.axes
                point = opening.centre + share * opening.radius * across
                sides = [gap(point + step * opening.axes[0], f) for step in (-1e-7, 1e-7)]
                assert sides[0][0] == pytest.approx(sides[1][0], abs=1e-7)
                assert sides[0][0] == pytest.approx(opening.radius * (1 - share), abs=1e-7)
                assert sides[0][1] == pytest.approx(sides[1][1], abs=1e-5)
                assert sides[0][1] == pytest.approx(across, abs=1e-5)


def test_the_water_is_where_the_gap_is_positive():
    f, rng = wall_array(WINDING), np.random.default_rng(4)
    points = rng.uniform([0.2, -0.4, -0.6], [1.2, 0.6, 0.4], (40_000, 3))
    inside = WINDING.layout.find_part(points) >= 0
    found = np.array([gap(p, f)[0] for p in points]) >= 0
    # The straight rows beyond inlet and outlets, and the rounding of the tee's edge, are water of the kernel alone.
    assert not (inside & ~found).any()
    assert inside.sum() > 500


def test_a_body_that_is_called_far_touches_nothing():
    f, rng = wall_array(WINDING), np.random.default_rng(5)
    far = 0
    for placed in WINDING.layout.parts:
        for axis in placed.part.list_axes(0.02):
            for k in rng.integers(len(axis.points), size=20):
                centre = axis.points[k] + rng.uniform(-0.4, 0.4, 3) * axis.radii[k]
                reach = float(rng.uniform(0.05, 0.8) * axis.radii[k])
                if is_far_in_fittings(tuple(centre), reach, f):
                    far += 1
                    out = rng.normal(size=(40, 3))
                    ball = centre + reach * out / np.linalg.norm(out, axis=1, keepdims=True)
                    assert min(gap(p, f)[0] for p in ball) > 0
    assert far > 40


def test_rows_have_a_sphere_around_their_part():
    rows = wall_rows(WINDING.layout)
    assert wall_array(WINDING)[HEAD:].reshape(len(rows), -1) == pytest.approx(rows)
    kinds = [type(placed.part) for placed in WINDING.layout.parts]
    assert {Bend, Reducer, Tee} <= set(kinds)
    for placed, row in zip(WINDING.layout.parts, rows, strict=False):
        for axis in placed.part.list_axes(0.003):
            reach = np.linalg.norm(axis.points - row[24:27], axis=1) + axis.radii
            assert (reach < row[27]).all()
