"""Added mass against closed forms, published values, other origins, and itself with twice as many panels."""

import math
import threading

import numpy as np
import pytest
from solids import reciprocity, remus_body

from driftform.agent import solid_of_revolution
from driftform.motion.forces.inertia import shift_origin
from driftform.testing.bodies import cylinder_body, dome_body, spheroid_body
from driftform.water import Fluid
from driftform_panels import solve as module
from driftform_panels.meridian import Panels, make_panels
from driftform_panels.solve import PanelOptions, solve, solve_panels
from driftform_striptheory.coefficients import StripTheory, StripTheoryOptions

CUP = np.array([(0, 0), (0, 1), (3, 1), (3, 0.7), (1, 0.7), (1, 0)], dtype=float)
"""Thick walls, closed aft: its contour folds back along x."""


def lamb(a, b):
    """Added mass of a spheroid in fluid of density 1: surge, sway and yaw (Lamb, sections 114 and 115)."""
    s, volume = b / a, 4 / 3 * np.pi * a * b * b
    if s == 1:
        alpha = 2 / 3
    elif s < 1:
        e = math.sqrt(1 - s * s)
        alpha = 2 * s * s / e**3 * (math.atanh(e) - e)
    else:
        e = math.sqrt(1 - 1 / (s * s))
        alpha = 2 * (1 / e**2 - math.asin(e) / (s * e**3))
    beta = (2 - alpha) / 2
    difference, total = a * a - b * b, a * a + b * b
    turning = 0.0
    if s != 1:
        turning = difference**2 * (beta - alpha) / (total * (2 * difference - total * (beta - alpha)))
    return np.array([alpha / (2 - alpha), beta / (2 - beta), turning * total / 5]) * volume


def strip_theory(body):
    """The paper's added mass in fluid of density 1."""
    return StripTheory(StripTheoryOptions()).coefficients(body, Fluid(density=1.0)).added_mass


def values(solution):
    """Surge, sway, yaw and their coupling."""
    coupling = (solution.sway_of_yaw + solution.yaw_of_sway) / 2
    return np.array([solution.surge, solution.sway, solution.yaw, coupling])


def change(actual, expected):
    """Relative difference of surge, sway and yaw, and that of the coupling relative to sqrt(A22 A66)."""
    size = values(expected)
    size[3] = math.sqrt(expected.sway * expected.yaw)
    return np.abs(values(actual) - values(expected)) / size


def halved(divided):
    """The same curves with every panel cut in two, at the middle of its parameter."""
    first = np.diag([1 / 8, 1 / 4, 1 / 2, 1])
    second = np.array([[1, 0, 0, 0], [3, 2, 0, 0], [3, 4, 4, 0], [1, 2, 4, 8]]) / 8
    x, r = (np.stack([curve @ first.T, curve @ second.T], axis=1).reshape(-1, 4) for curve in (divided.x, divided.r))
    return Panels(x, r, np.repeat(divided.lengths / 2, 2))


SPHEROIDS = [(6, 1), (4, 1), (2, 1), (1, 1), (1, 2), (1, 5)]


@pytest.mark.parametrize(("a", "b"), SPHEROIDS, ids=str)
def test_spheroids_agree_with_lamb(a, b):
    solution = solve(spheroid_body(a, b, edges=256).outer)
    expected = lamb(a, b)
    np.testing.assert_allclose([solution.surge, solution.sway], expected[:2], rtol=1e-3)
    assert solution.yaw == pytest.approx(expected[2], rel=2e-3, abs=1e-6 * expected[1])


def test_the_page_shows_how_well_spheroids_agree_with_lamb(published):
    def off(found, expected):
        # A sphere that turns moves nothing, and nothing has no errors in percent.
        if expected == 0:
            return f"{found:.4f} for 0"
        percent = round(100 * (found / expected - 1), 3) + 0.0
        return f"{percent:+.3f} %" if abs(percent) < 1 else f"{percent:+.0f} %"

    lines = ["| spheroid | k1 | panels | strips | k2 | panels | strips | k' | panels | strips |", "|---" * 10 + "|"]
    for a, b in SPHEROIDS:
        body = spheroid_body(a, b, edges=256)
        water = np.array([1, 1, (a * a + b * b) / 5]) * 4 / 3 * np.pi * a * b * b
        solution, strips = solve(body.outer), strip_theory(body)
        rows = zip(
            lamb(a, b) / water,
            np.array([solution.surge, solution.sway, solution.yaw]) / water,
            strips[[0, 1, 5], [0, 1, 5]] / water,
            strict=True,
        )
        cells = [cell for k, panel, strip in rows for cell in (f"{k:.4f}", off(panel, k), off(strip, k))]
        lines.append(f"| {a}:{b} | " + " | ".join(cells) + " |")
    published("spheroids", lines)


@pytest.mark.parametrize(("a", "b"), [(6, 1), (1, 1), (1, 5)], ids=str)
def test_the_rest_of_that_error_is_from_the_polyline(a, b):
    solution = solve(spheroid_body(a, b, edges=2048).outer)
    np.testing.assert_allclose([solution.surge, solution.sway], lamb(a, b)[:2], rtol=2e-5)


# Length over diameter, axis of the motion, added over displaced mass by another code of axisymmetric panels.
CYLINDERS = [(1.2, "sway", 0.623), (5.0, "sway", 0.877), (2.5, "surge", 0.248)]


def added_over_displaced(ratio, motion):
    return getattr(solve(cylinder_body(2 * ratio, 1.0).outer), motion) / (2 * ratio * np.pi)


@pytest.mark.parametrize(("ratio", "motion", "k"), CYLINDERS)
def test_cylinders_have_the_added_mass_that_another_code_finds(ratio, motion, k):
    assert added_over_displaced(ratio, motion) == pytest.approx(k, rel=3e-3)


def test_the_page_shows_how_well_cylinders_agree_with_another_code(published):
    lines = ["| L/d | motion | other code | panels | off by | strip theory |", "|---|---|---|---|---|---|"]
    for ratio, motion, k in CYLINDERS:
        body = cylinder_body(2 * ratio, 1.0)
        axis = ("surge", "sway").index(motion)
        strips = strip_theory(body)[axis, axis] / (2 * ratio * np.pi)
        found = added_over_displaced(ratio, motion)
        off = 100 * (found / k - 1)
        lines.append(f"| {ratio} | {motion} | {k:.3f} | {found:.4f} | {off:+.2f} % | {strips:.3f} |")
    published("cylinders", lines)


FLAT_PANELS = {
    "cup": ([(0, 0), (0, 2), (6, 2), (6, 1.4), (2, 1.4), (2, 0)], (54.80, 71.72, 160.70, 56.08)),
    "bicone": ([(0, 0), (1, 1), (3, 0.5), (4, 1.5), (4, 0)], (7.894, 5.270, 8.226, 0.4185)),
    "disc": ([(0, 0), (0, 2), (0.8, 2), (0.8, 0)], (25.80, 2.355, 13.39, 0.0)),
}
"""Surge, sway, yaw and coupling of bodies cut into plane quadrilaterals of constant potential, whose integrals have closed
forms (Hess and Smith 1967), without rings or elliptic integrals: the limit of meshes of 32 and 64 around the axis."""


@pytest.mark.parametrize("name", FLAT_PANELS)
def test_bodies_with_hollows_and_sharp_edges_have_the_added_mass_of_flat_panels(name):
    contour, expected = FLAT_PANELS[name]
    found = values(solve(contour))
    unit = np.array([*found[:3], math.sqrt(found[1] * found[2])])
    np.testing.assert_allclose(found / unit, expected / unit, rtol=0, atol=3e-3)


def test_a_long_cylinder_is_two_dimensional_across_its_axis():
    solution = solve(cylinder_body(400.0, 1.0).outer)
    assert solution.sway / (400 * np.pi) == pytest.approx(1, rel=5e-3)
    assert solution.yaw / (400**3 * np.pi / 12) == pytest.approx(1, rel=1e-2)


def test_the_hull_of_remus_100_moves_more_water_than_its_spheroid():
    """Prestero's -0.930 is the surge of the spheroid of the same length and diameter; Myring's hull has fuller ends."""
    hull = remus_body()
    spheroid = spheroid_body(hull.length / 2, hull.max_diameter / 2, edges=256)
    assert 1030 * solve(spheroid.outer).surge == pytest.approx(0.930, rel=0.02)
    # Capytaine's value for the hull, too (test_capytaine).
    assert 1030 * solve(hull.outer).surge == pytest.approx(1.556, rel=0.01)


@pytest.mark.parametrize(
    "contour", [dome_body(1.0).outer, CUP, cylinder_body(3.0, 1.0).outer], ids=["dome", "cup", "cylinder"]
)
@pytest.mark.parametrize("offset", [0.7, -20.0])
def test_about_another_origin_the_matrix_is_shifted(contour, offset):
    here, there = solve(contour), solve(contour, origin=solve(contour).origin + offset)
    expected = shift_origin(here.matrix(), np.array([offset, 0.0, 0.0]))
    np.testing.assert_allclose(there.matrix(), expected, rtol=1e-5, atol=1e-5 * expected[1, 1])


def test_random_bodies_are_reciprocal(random_bodies):
    assert max(reciprocity(solve(body.outer)) for body in random_bodies(20, 1)) < 1e-4


def test_with_every_panel_cut_in_two_random_bodies_stay_as_they_are(random_bodies):
    worst = np.zeros(4)
    for body in random_bodies(20, 1):
        contour = body.outer - (solid_of_revolution(body.outer).centroid, 0.0)
        divided = make_panels(contour, 15, 0.2)
        twice = halved(divided)
        assert len(twice.lengths) == 2 * len(divided.lengths)
        worst = np.maximum(worst, change(solve_panels(divided), solve_panels(twice)))
    assert (worst < [5e-4, 2e-4, 5e-4, 5e-4]).all(), worst


@pytest.mark.parametrize(
    ("contour", "most"),
    [
        (CUP, 5e-4),
        (cylinder_body(3.0, 1.0).outer, 5e-4),
        (cylinder_body(0.2, 1.0).outer, 5e-4),
        (np.array([(0, 0), (0, 1), (0.3, 0)]), 2e-3),
        (np.array([(0, 0), (50, 1), (100, 0)]), 2e-3),
        (np.array([(0, 0), (0, 1), (3, 1), (3, 0.95), (1, 0.95), (1, 0)]), 5e-4),
        (np.array([(0, 0), (0, 0.1), (2, 0.1), (2, 3), (2.05, 3), (2.05, 0.1), (4, 0.1), (4, 0)]), 3e-3),
    ],
    ids=["cup", "cylinder", "disc", "flat cone", "needle", "thin cup", "plate on a rod"],
)
def test_with_finer_options_odd_shapes_stay_as_they_are(contour, most):
    assert change(solve(contour), solve(contour, PanelOptions(panels=60, corner=0.02))).max() < most


def test_a_wall_that_its_panels_cannot_resolve_is_refused():
    thin = [(0, 0), (0, 1), (3, 1), (3, 0.998), (1, 0.998), (1, 0)]
    with pytest.raises(ValueError, match=r"raise hydrodynamics\.panels"):
        solve(thin)
    assert reciprocity(solve(thin, PanelOptions(panels=120, corner=0.01))) < 1e-4


def test_a_contour_that_touches_itself_is_refused():
    with pytest.raises(ValueError, match="touch itself"):
        solve([(0, 0), (0, 1), (1, 1), (1, 0.5), (1, 1), (2, 1), (2, 0)])


def test_it_solves_with_one_thread_and_leaves_the_others_alone(monkeypatch):
    def threads():
        # Libraries loaded later are left out: scipy includes another one, which numpy does not use.
        return [pool["num_threads"] for pool in module._find_libraries().info() if pool["user_api"] == "blas"]

    before, during = threads(), []
    solver = np.linalg.solve
    monkeypatch.setattr(module.np.linalg, "solve", lambda *system: (during.append(threads()), solver(*system))[1])
    solve(CUP)
    assert during
    assert {count for found in during for count in found} == {1}
    assert threads() == before


def test_threads_find_what_one_finds():
    alone = values(solve(CUP))
    found = []
    workers = [threading.Thread(target=lambda: found.append(values(solve(CUP)))) for _ in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert len(found) == 4
    # The number of threads belongs to the process: one solve that ends gives it back to another, which then rounds
    # differently.
    for other in found:
        np.testing.assert_allclose(other, alone, rtol=1e-9, atol=1e-9 * np.abs(alone).max())
