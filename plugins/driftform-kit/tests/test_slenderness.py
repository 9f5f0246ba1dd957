"""Parts as beams on the bed: closed forms of Euler and Bernoulli, and the cuts and brims that the check advises."""

import re

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from manifold3d import CrossSection

from driftform.interfaces import Printer, PrintJob
from driftform.types import State
from driftform_frusta.triangles import Mesh
from driftform_kit.checks.mesh import MeshChecker, MeshOptions
from driftform_kit.checks.slenderness import find_brim, measure_section, measure_slenderness

E, YIELD, BED = 2e9, 33e6, 1e5


def measure(mesh):
    return measure_slenderness(Mesh(mesh.vertices, mesh.faces), E, YIELD, BED)


def revolve(*profile):
    return trimesh.creation.revolve(np.array(profile), sections=256)


@given(st.floats(2, 20), st.floats(2, 20), st.floats(0, 180))
def test_a_rectangle_is_weakest_across_its_short_side_however_it_is_turned(a, b, deg):
    second, width = measure_section(CrossSection.square((a, b)).rotate(deg).translate((3.0, -50.0)))
    assert second == pytest.approx(max(a, b) * min(a, b) ** 3 / 12, rel=1e-6)
    if abs(a - b) > 1e-3:
        assert width == pytest.approx(min(a, b), rel=1e-6)


def test_a_tube_has_the_moment_of_its_ring():
    second, width = measure_section(CrossSection.circle(5.0, 720) - CrossSection.circle(3.0, 720))
    assert second == pytest.approx(np.pi / 4 * (5**4 - 3**4), rel=1e-4)
    assert width == pytest.approx(10, rel=1e-4)


def test_a_cylinder_bends_lifts_and_breaks_by_the_closed_forms_of_a_clamped_beam():
    r, height = 4.0, 100.0
    found = measure(revolve((0, 0), (r, 0), (r, height), (0, height)))
    second, modulus = np.pi / 4 * r**4, np.pi / 4 * r**3
    assert (found.height, found.base) == pytest.approx((height, 2 * r), rel=1e-3)
    # It is clamped in the middle of its first layer, 0.1 mm above the bed: 0.3 % less lever, cubed.
    assert found.bending == pytest.approx((height - 0.1) ** 3 / (3 * 1e-6 * E * second), rel=1e-3)
    assert found.lift_force == pytest.approx(1e-6 * BED * modulus / height, rel=1e-3)
    assert found.break_force == pytest.approx(1e-6 * YIELD * modulus / height, rel=3e-3)
    assert found.neck_height < 1


def test_a_cone_that_stands_on_its_foot_bends_as_tapered_beams_do():
    # With r = R (1 - k z / H) the integral of (H - z)^2 / I is 4 H^3 / (pi R^4) int (1 - s)^2 / (1 - k s)^4 ds.
    big, small, height = 6.0, 3.0, 80.0
    found = measure(revolve((0, 0), (big, 0), (small, height), (0, height)))
    s = (np.arange(20000) + 0.5) / 20000
    integral = float(((1 - s) ** 2 / (1 - 0.5 * s) ** 4).mean())
    assert found.bending == pytest.approx(4 * height**3 / (np.pi * big**4) * integral / (1e-6 * E), rel=2e-3)


def test_the_neck_is_found_where_it_is():
    bell = revolve((0, 0), (10, 0), (10, 30), (2, 38), (2, 42), (10, 50), (10, 90), (0, 90))
    found = measure(bell)
    assert found.neck == pytest.approx(4, rel=1e-2)
    assert found.neck_height == pytest.approx(38.2, abs=0.5)
    assert found.base == pytest.approx(20, rel=1e-3)


def test_what_is_no_higher_than_a_layer_is_not_measured():
    flat = trimesh.creation.box((20, 20, 0.15))
    assert measure_slenderness(Mesh(flat.vertices, flat.faces), E, YIELD, BED) is None


def check(mesh, folder, **options):
    path = folder / "part.stl"
    path.write_bytes(Mesh(mesh.vertices, mesh.faces).to_stl())
    found = MeshChecker(MeshOptions(**options)).check(PrintJob((path,), Printer()))
    [line] = [finding for finding in found if finding.check == "slender"]
    return line


def test_a_tower_on_a_foot_warns_that_it_sways(tmp_path):
    tower = revolve((0, 0), (12, 0), (12, 3), (3, 3), (3, 190), (0, 190))
    line = check(tower, tmp_path)
    assert line.state is State.WARN
    # 0.098 N at 187 mm on a rod of 63.6 mm4 and 2 GPa: 1.68 mm, and hardly any from the foot.
    assert "(7.9 : 1)" in line.detail
    bent = re.search(r"0\.098 N bend it by ([\d.]+) mm", line.detail)
    assert bent is not None and float(bent.group(1)) == pytest.approx(1.68, abs=0.02)
    assert "sways by more than half a line (0.2 mm)" in line.detail
    assert "brim" not in line.detail and "catches" not in line.detail
    assert check(tower, tmp_path, stiffness=5e10).state is State.PASS


def test_a_part_that_is_steady_by_its_area_but_sticks_too_little_warns(tmp_path):
    stout = revolve((0, 0), (5, 0), (5, 60), (0, 60))
    # 98 mm3 of first layer: at 0.1 MPa they hold 0.16 N at 60 mm, at 0.02 MPa, as PLA sticks, 0.033 N.
    assert check(stout, tmp_path).state is State.PASS
    line = check(stout, tmp_path, adhesion=2e4)
    assert line.state is State.WARN and "0.033 N lift it off the bed" in line.detail
    assert "a nozzle pushes with 0.098 N and lifts it off: print it with a brim of 3 mm" in line.detail


def test_a_thin_neck_below_a_long_lever_warns_that_it_breaks(tmp_path):
    neck = revolve((0, 0), (10, 0), (10, 30), (1, 39), (1, 41), (10, 50), (10, 120), (0, 120))
    line = check(neck, tmp_path)
    assert line.state is State.WARN and "catches, with 0.73 N, breaks it" in line.detail
    # A rod of 2 mm across: W = 0.785 mm3, 33 MPa, a lever of 81 mm.
    assert "0.32 N break it" in line.detail


ROD = ((0, 0), (3, 0), (3, 80), (20, 97), (20, 100), (3, 117), (3, 170), (0, 170))
"""A rod that a disc keeps from lying on the bed."""


def test_a_tall_part_on_a_small_foot_warns_first_that_it_is_lifted_off(tmp_path):
    rod = revolve(*ROD)
    line = check(rod, tmp_path)
    # W = 21.2 mm3: at 0.1 MPa and 170 mm 0.012 N lift it off, and it would sway, too.
    assert line.state is State.WARN and "0.012 N lift it off the bed" in line.detail
    lifted, sways = line.detail.index("and lifts it off: print it with a brim"), line.detail.index("it sways")
    assert lifted < sways and "(--kit, --bed)" in line.detail


@pytest.mark.parametrize(("radius", "height"), [(3.0, 170.0), (5.0, 60.0), (2.0, 80.0)])
def test_the_brim_that_is_named_holds_and_the_next_smaller_one_does_not(radius, height):
    rod = revolve((0, 0), (radius, 0), (radius, height), (0, height))
    brim = find_brim(Mesh(rod.vertices, rod.faces), 0.098, 2e4)
    widths = (0.0, 3.0, 5.0, 8.0, 12.0, 16.0)
    assert brim in widths[1:]
    for width, holds in ((brim, True), (widths[widths.index(brim) - 1], False)):
        around = radius + width
        # A disc of that radius, W = pi r^3 / 4, at a stress of 0.02 MPa; and the root of its area is a tenth of the height.
        lifted = 0.02 * np.pi / 4 * around**3 / height < 0.098
        assert (not lifted and np.sqrt(np.pi) * around >= 0.1 * height) == holds


def test_a_ball_that_touches_the_bed_in_a_point_gets_a_brim():
    # In the middle of the first layer it is 2.8 mm across, and 2 mm at a quarter of it.
    ball = trimesh.creation.icosphere(subdivisions=5, radius=10.0)
    assert find_brim(Mesh(ball.vertices, ball.faces)) == 3.0
