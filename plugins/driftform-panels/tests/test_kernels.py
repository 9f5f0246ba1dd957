"""Rings against scipy's elliptic integrals, quadrature over the ring and series; equations against identities."""

import numpy as np
import pytest
from scipy.special import ellipe, ellipkm1

from driftform.testing.bodies import cylinder_body, spheroid_body
from driftform_panels import meridian
from driftform_panels.kernels import assemble_equations, integrate_rings
from driftform_panels.meridian import make_panels


def acting(x, r, rows):
    """What rings (x', r', n_x, n_r) do at (x, r), (5, n)."""
    source = np.ascontiguousarray(np.transpose(rows))
    out = np.empty((5, source.shape[1]))
    integrate_rings(x, r, source, source.shape[1], out)
    return out


def by_quadrature(x, r, row, points):
    """The same, ring by ring, by the trapezoidal rule over the circle, which converges faster than any power."""
    xs, s, nx, nr = row
    theta = 2 * np.pi * np.arange(points) / points
    c = np.cos(theta)
    distance = np.sqrt((x - xs) ** 2 + r * r + s * s - 2 * r * s * c)
    double = (nx * (x - xs) + nr * (r * c - s)) / distance**3
    i0, i1, d0, d1 = (f.mean() * 2 * np.pi * s for f in (1 / distance, c / distance, double, c * double))
    return np.array([i0 * nx, i1 * nr, i1 * (xs * nr - s * nx), d0, d1])


@pytest.mark.parametrize("ratio", np.geomspace(1e-6, 1, 25))
def test_complete_elliptic_integrals_agree_with_scipy(ratio):
    # b / a = |r - s| / (r + s) in the plane of the ring.
    r = 1.0
    s = r * (1 - ratio) / (1 + ratio) if ratio < 1 else 1e-12
    a, b, p = r + s, r - s, 2 * r * s
    i0, i1 = acting(0.0, r, [(0.0, s, 1.0, 1.0)])[:2, 0] / s
    assert a * i0 / 4 == pytest.approx(ellipkm1((b / a) ** 2), rel=1e-14)
    second = ((a * a - p) * i0 - p * i1) / (4 * a)
    assert second == pytest.approx(ellipe(p * 2 / a**2), rel=1e-13)


@pytest.mark.parametrize("seed", range(20))
def test_rings_agree_with_quadrature_over_the_circle(seed):
    rng = np.random.default_rng(seed)
    x, xs, nx, nr = rng.normal(size=4)
    r, s = rng.uniform(0.05, 2, size=2)
    row = (xs, s, nx, nr)
    expected = by_quadrature(x, r, row, 20_000)
    np.testing.assert_allclose(acting(x, r, [row])[:, 0], expected, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("gap", [1e-2, 1e-3])
def test_rings_agree_with_quadrature_near_the_ring(gap):
    for angle in np.linspace(0, 6, 7):
        row = (0.3, 1.0, np.cos(1.0), np.sin(1.0))
        x, r = 0.3 + gap * np.cos(angle), 1.0 + gap * np.sin(angle)
        expected = by_quadrature(x, r, row, int(200 / gap))
        np.testing.assert_allclose(acting(x, r, [row])[:, 0], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("far", [1e1, 1e3, 1e6])
def test_nothing_cancels_far_away_and_on_the_axis(far):
    # I1 = pi / sqrt(A) (z / 2 + 15 z^3 / 64 + ...) with z = p / A; J0, J1 and J2 in the same way.
    r, s = 1e-3, 0.7
    A = far * far + r * r + s * s
    z = 2 * r * s / A
    _, i1, _, d0, d1 = acting(far, r, [(0.0, s, 1.0, 1.0)])[:, 0]
    assert i1 == pytest.approx(s * np.pi / np.sqrt(A) * (z / 2 + 15 * z**3 / 64), rel=1e-12)
    j0 = 2 * np.pi * A**-1.5 * (1 + 15 * z**2 / 16)
    j1 = np.pi * A**-1.5 * (3 * z / 2 + 105 * z**3 / 64)
    j2 = np.pi * A**-1.5 * (1 + 45 * z**2 / 32)
    assert d0 == pytest.approx(s * (far * j0 + r * j1 - s * j0), rel=1e-12)
    assert d1 == pytest.approx(s * (far * j1 + r * j2 - s * j1), rel=1e-11)


def identity_errors(contour):
    """How far x (m = 0) and r cos(theta) (m = 1), harmonic inside the body, are from Green's identity inside.

    There 2 pi phi + D phi = S dphi/dn, with D as it is for the outside.
    """
    divided = make_panels(contour, 15, 0.2)
    matrices, sides, (x, r, _, _) = assemble_equations(divided.x, divided.r, divided.lengths)
    surge = 4 * np.pi * x - matrices[0] @ x + sides[:, 0]
    sway = 4 * np.pi * r - matrices[1] @ r + sides[:, 1]
    return np.abs(surge).max() / np.abs(x).max(), np.abs(sway).max() / r.max()


@pytest.mark.parametrize(("body", "error"), [(cylinder_body(3.0, 1.0), 1e-5), (spheroid_body(1.0, 0.5, 512), 1e-4)])
def test_a_uniform_flow_inside_satisfies_greens_identity(body, error, monkeypatch):
    # With points that crowd at corners, x and r would be no quadratics in a panel's parameter.
    monkeypatch.setattr(meridian, "CROWDING", 0.0)
    surge, sway = identity_errors(body.outer)
    assert surge < error
    assert sway < error


def test_a_constant_potential_has_no_flow():
    divided = make_panels(cylinder_body(3.0, 1.0).outer, 15, 0.2)
    matrices, _, _ = assemble_equations(divided.x, divided.r, divided.lengths)
    np.testing.assert_allclose(matrices[0].sum(axis=1), 4 * np.pi, rtol=1e-13)
