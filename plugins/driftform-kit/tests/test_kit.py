"""Kits of random agents: parts measured on their own meshes, as a slicer reads them, and put together by hand."""

import math
from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from manifold3d import Error, Manifold, Mesh64
from prints import chain_body

from driftform.errors import WorkFailedError
from driftform.types import Body, Core, Module, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.csg import Revolve
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_frusta.solid import to_manifold
from driftform_frusta.triangles import Mesh, area_factor
from driftform_kit.cutting.joint import Joint, draw_joint
from driftform_kit.cutting.meridian import draw_tube, make_polygons
from driftform_kit.cutting.pieces import make_kit

WALL = 1.25e-3
NOTHING = 1e-6  # mm3

MODULES = st.lists(
    st.builds(
        Module,
        st.sampled_from([0.0025, 0.005, 0.01]),
        st.sampled_from([math.radians(t) for t in (-20, -10, 0, 10, 20)]),
    ),
    max_size=9,
)
BODIES = st.builds(
    lambda fore, aft: FrustaBuilder(FrustaOptions()).build(Morphology(tuple(fore), tuple(aft))), MODULES, MODULES
)
CLEARANCES = st.sampled_from([0.0001, 0.0002, 0.0003, 0.0004])


def cylinder(radius, half):
    """A capped tube about its core."""
    inside, end = radius - WALL, half - WALL
    return Body(
        outer=[[-half, 0], [-half, radius], [half, radius], [half, 0]],
        cavity=[[-end, 0], [-end, inside], [end, inside], [end, 0]],
        joints=[-half, -half / 2, 0, half / 2, half],
        core=Core(0.01, 0.05),
        wall=WALL,
        hull_density=1050.0,
    )


def reread(solid):
    """The solid of the mesh that a file in single precision holds."""
    mesh = Mesh(solid.vertices.astype(np.float32), solid.triangles).merge_vertices()
    assert mesh.is_closed
    assert mesh.volume > 0
    again = Manifold(Mesh64(mesh.vertices.astype(np.float64), mesh.triangles.astype(np.uint64)))
    assert again.status() == Error.NoError
    return again


@cache
def ball(radius):
    # So many corners that its facets are within a hundredth of a millimetre of the sphere.
    return Manifold.sphere(radius, 96)


class Assembled:
    """A kit put together: its parts reread, and the core."""

    def __init__(self, body, **options):
        self.body, self.options = body, PartOptions(kit=True, **options)
        self.kit = make_kit(body, self.options)
        self.parts = make_parts(body, self.options)
        self.solids = [reread(part.solid) for part in self.parts]
        self.lift = -1e3 * body.outer[0, 0]
        self.radius = 1e3 * body.core.radius
        self.core = self.core_at(0.0)

    def core_at(self, x):
        return ball(self.radius).translate((0.0, 0.0, self.lift + x))

    def slice(self, index, low, high):
        low, high = sorted((low, high))
        cut = self.solids[index].trim_by_plane((0, 0, 1), low + self.lift)
        return cut.trim_by_plane((0, 0, -1), -(high + self.lift))

    def gaps(self, joint):
        """Distance between both parts in four places along the lap, between its chamfers, mm."""
        index = self.kit.joints.index(joint)
        places = joint.z + joint.side * np.linspace(-0.4, 0.4 - joint.lap, 5)
        return [
            self.slice(index, low, high).min_gap(self.slice(index + 1, low, high), 5.0)
            for low, high in pairwise(places)
        ]


def check(body, **options):
    """What holds of every kit."""
    made = Assembled(body, **options)
    for part, solid in zip(made.parts, made.solids, strict=True):
        assert len(part.solid.shells) == 1 == len(solid.decompose())
        assert solid.volume() == pytest.approx(part.solid.volume, rel=1e-5)
        assert (solid ^ made.core).volume() < NOTHING
    for one, other in combinations(made.solids, 2):
        assert (one ^ other).volume() < NOTHING
    for joint in made.kit.joints:
        assert made.gaps(joint) == pytest.approx([1e3 * made.options.clearance] * 4, abs=0.02)
    return made


@pytest.mark.parametrize("joint", ["auto", "rabbet"])
@settings(max_examples=5, deadline=None)
@given(BODIES, CLEARANCES)
def test_parts_of_any_agent_are_closed_and_leave_the_gap_that_was_asked_for(joint, body, clearance):
    made = check(body, clearance=clearance, joint=joint)
    assert joint == "auto" or made.kit.core_joint.z == 0.0


@settings(max_examples=6, deadline=None)
@given(BODIES)
def test_a_kit_looks_from_outside_like_the_hull_that_was_simulated(body):
    made = Assembled(body)
    outside = to_manifold(Revolve(tuple((1e3 * r, 1e3 * x) for x, r in body.outer)))
    sealed = outside.translate((0.0, 0.0, made.lift))
    for solid in made.solids:
        assert (solid - sealed).volume() < 1e-4 * solid.volume()
    # What encloses a kit is the outside again: rims bear on each other without a step or a slit.
    skin = sealed - sealed.scale((0.999, 0.999, 1.0))
    covered = sum((skin ^ solid).volume() for solid in made.solids)
    assert covered == pytest.approx(skin.volume(), rel=2e-3)


@settings(max_examples=6, deadline=None)
@given(BODIES)
def test_the_core_goes_in_through_the_mouth_and_the_shells_close_over_it(body):
    made = Assembled(body)
    joint, index = made.kit.core_joint, made.kit.joints.index(made.kit.core_joint)
    socket, plug = (index, index + 1) if joint.side > 0 else (index + 1, index)
    way = 3 * made.radius + abs(joint.z)
    path = Manifold.cylinder(way, made.radius, made.radius, 96)
    if joint.side < 0:
        path = path.translate((0.0, 0.0, -way))
    assert (made.solids[socket] ^ path.translate((0.0, 0.0, made.lift))).volume() < NOTHING
    for away in np.linspace(0.01, joint.lap, 12):
        moved = made.solids[plug].translate((0.0, 0.0, joint.side * away))
        assert (moved ^ made.solids[socket]).volume() < NOTHING


@settings(max_examples=6, deadline=None)
@given(BODIES)
def test_the_core_is_held_where_it_was_simulated(body):
    made = Assembled(body)
    for side in (-1, 1):
        struck = sum((solid ^ made.core_at(side * 0.6)).volume() for solid in made.solids)
        assert struck > NOTHING


def footing(solid):
    """Area on the bed, and area that leans out by more than 45 degrees above it, mm2."""
    corners = solid.vertices[solid.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1) / 2
    steep = normal[:, 2] < -math.sin(math.radians(45.5)) * 2 * area
    on_bed = corners[:, :, 2].max(axis=1) < corners[:, :, 2].min() + 0.01
    return area[on_bed].sum(), area[steep & ~on_bed].sum()


@settings(max_examples=6, deadline=None)
@given(BODIES)
def test_a_part_stands_on_the_end_that_leaves_less_hanging_in_the_air(body):
    for part in make_parts(body, PartOptions(kit=True)):
        foot, hanging = footing(part.on_bed())
        other_foot, other_hanging = footing(part.on_bed().turn_over())
        assert hanging <= other_hanging + 1 or other_foot < 10
        assert foot > 10


def test_joints_and_seats_need_no_support():
    """Here the hull itself has nothing that hangs: its walls lean by 20 degrees, and its caps are on the bed."""
    for body in (chain_body("sss", "sss"), chain_body("uus", "sun"), chain_body("ssn", "nuu"), cylinder(0.03, 0.05)):
        made = Assembled(body)
        assert made.kit.core_joint.kind == "sleeve" and made.kit.seats
        aft, fore = made.parts
        assert (aft.fore_down, fore.fore_down) == (False, True)
        assert footing(aft.on_bed())[1] < 1 and footing(fore.on_bed())[1] < 1
    # A dome is printed with its open end down.
    assert [part.fore_down for part in make_parts(chain_body(), PartOptions(kit=True))] == [True, False]


def test_one_sided_and_very_short_agents_make_kits_too():
    for body in (
        chain_body(),
        chain_body("n"),
        chain_body("", "uuu"),
        chain_body("u"),
        chain_body("ss"),
        chain_body("", "nnnn"),
    ):
        made = check(body)
        assert [part.name for part in made.parts] == ["aft shell", "fore shell"]


def test_a_hull_that_stays_wide_gets_a_sleeve_beside_the_core():
    kit = make_kit(chain_body("sss", "nn"), PartOptions(kit=True))
    joint = kit.core_joint
    assert joint.kind == "sleeve"
    # A ball of 10.2 mm leaves room for a ring of 8.8 mm inside where it is 5.16 mm from the equator.
    assert joint.tip == pytest.approx(math.sqrt(10.2**2 - 8.8**2), abs=0.26)
    assert f"{joint.z:g} mm fore of the core's equator" in kit.reason


def test_a_hull_with_room_around_the_core_is_cut_at_its_equator():
    kit = make_kit(cylinder(0.0129, 0.03), PartOptions(kit=True))
    assert kit.core_joint.z == 0.0
    assert kit.core_joint.kind == "sleeve"
    assert kit.reason.endswith("at the core's equator")


def test_a_sleeve_has_the_lap_the_thickness_and_the_gap_that_were_asked_for():
    made = check(cylinder(0.02, 0.03), sleeve=0.002, lap=0.008, clearance=0.0003)
    joint = made.kit.core_joint
    plug = made.slice(1, -7.0, -1.0)
    bore = 20 - 1.25
    ring = math.pi * ((bore - 0.3) ** 2 - (bore - 2.3) ** 2) * 6
    assert plug.volume() == pytest.approx(ring, rel=1e-4)
    assert joint.tip == -8.0
    assert made.solids[1].bounding_box()[2] == pytest.approx(made.lift - 8.0, abs=1e-4)


@pytest.mark.parametrize("clearance", [0.0001, 0.0002, 0.0004])
def test_a_rabbet_shares_the_wall_between_two_steps(clearance):
    made = check(chain_body("ss", "ss"), joint="rabbet", clearance=clearance)
    joint = made.kit.core_joint
    step = (1.25 - 1e3 * clearance) / 2
    at = joint.z - joint.side * joint.lap / 2
    steps = []
    for index in (0, 1):
        section = made.slice(index, at - 0.1, at + 0.1)
        radii = np.hypot(*np.asarray(section.to_mesh64().vert_properties)[:, :2].T) / area_factor(64)
        steps.append((radii.min(), radii.max()))
    (low, middle), (above, high) = sorted(steps)
    # The core's room is a polyline of 2.5 degrees, up to three thousandths of a millimetre inside its circle.
    assert (low, high) == pytest.approx((10.2, 11.45), abs=0.01)
    assert middle - low == pytest.approx(step, abs=0.01)
    assert high - above == pytest.approx(step, abs=0.01)


def test_a_wide_hull_has_a_cone_on_either_side_that_the_core_sits_on():
    made = check(cylinder(0.03, 0.04))
    assert len(made.kit.seats) == 2
    for index, solid in enumerate(made.solids):
        assert solid.min_gap(made.core, 1.0) == pytest.approx(0.2, abs=0.02), index


def test_parts_that_are_too_high_are_cut_at_joints_of_modules_and_fit_the_bed_then():
    body = chain_body("ssususnsus", "snsnsusnsu")
    made = check(body, bed=(0.2, 0.2, 0.055))
    names = [part.name for part in made.parts]
    assert names.index("aft shell") + 1 == names.index("fore shell")
    assert {"aft shell 2", "fore shell 2"} <= set(names)
    for part in made.parts:
        low, high = part.on_bed().bounds
        assert (high - low <= np.array([200, 200, 55]) + 1e-6).all()
    beside = [j.z for j in made.kit.joints if j is not made.kit.core_joint]
    for z in beside:
        assert np.abs(1e3 * body.joints - z).min() < 1e-9


def test_a_part_is_cut_no_oftener_than_the_bed_asks_for():
    body = cylinder(0.02, 0.1)
    assert len(make_parts(body, PartOptions(kit=True, bed=(0.2, 0.2, 0.12)))) == 2
    assert len(make_parts(body, PartOptions(kit=True, bed=(0.2, 0.2, 0.103)))) == 3
    assert len(make_parts(body, PartOptions(kit=True, bed=(0.2, 0.2, 0.07)))) == 4


@pytest.mark.parametrize(
    ("body", "options", "why"),
    [
        (cylinder(0.02, 0.1), {"bed": (0.03, 0.2, 0.2)}, "40.0 mm wide, the bed 30 x 200 mm"),
        (cylinder(0.02, 0.1), {"bed": (0.2, 0.2, 0.04)}, "too few joints of modules have room for a sleeve"),
        (chain_body("n", "n"), {"joint": "sleeve"}, "on neither side does the hull stay as wide as the core"),
        (chain_body("n", "n"), {"o_ring": 0.0015, "sleeve": 0.0019}, "there is no groove for an O-ring"),
        (chain_body("n", "n"), {"joint": "bayonet"}, "cavity of 22.0 mm or more across there. A larger radius"),
        (chain_body("n", "n"), {"clearance": 0.0006}, "steps of 0.325 mm"),
    ],
)
def test_what_cannot_be_made_is_refused_with_its_reason(body, options, why):
    with pytest.raises(WorkFailedError, match=r"no kit can be made|no sleeve") as refused:
        make_parts(body, PartOptions(kit=True, **options))
    assert why in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("cavity", "why"),
    [
        ([], "no cavity"),
        ([[-0.03, 0], [-0.03, 0.01875], [0.03, 0.01875], [0.03, 0]], "touches the outer contour"),
        ([[-0.02, 0], [-0.02, 0.009], [0.02, 0.009], [0.02, 0]], "core of 10 mm radius does not fit"),
        ([[0.001, 0], [0.001, 0.018], [0.02, 0.018], [0.02, 0]], "core of 10 mm radius does not fit"),
        ([[-0.02, 0], [0.02, 0.015], [-0.02, 0.018], [0.02, 0]], "folds back"),
    ],
)
def test_a_hull_that_takes_no_core_is_refused(cavity, why):
    body = Body(
        outer=[[-0.03, 0], [-0.03, 0.02], [0.03, 0.02], [0.03, 0]],
        cavity=np.reshape(cavity, (-1, 2)),
        joints=[-0.03, 0.03],
        core=Core(0.01, 0.05),
        wall=WALL,
        hull_density=1050.0,
    )
    with pytest.raises(WorkFailedError, match=why):
        make_parts(body, PartOptions(kit=True))


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("radii", [(12.0, 12.0, 11.8, 11.8), (12.0, 11.5, 11.8, 11.8), (11.8, 12.0, 11.9, 11.0)])
@pytest.mark.parametrize("turned", [False, True])
def test_a_socket_beside_a_ledge_of_the_cavity_does_not_cut_into_the_wall(side, radii, turned):
    # The cavity has a ledge 3 mm behind the cut.
    tube = draw_tube(12.0, 2.0, 10.0, -20.0, 20.0)
    at = -3.0 * side
    ordered = radii[::-1] if turned else radii
    bore = np.array(
        [(-21.0, 0.0), (-21.0, ordered[0]), (at, ordered[1]), (at, ordered[2]), (21.0, ordered[3]), (21.0, 0.0)]
    )
    polygon = [(sign * r, z) for sign in (1, -1) for z, r in bore[::sign]]
    hull = replace(tube, bore=bore, cavity=make_polygons([polygon]))
    joint = Joint(0.0, side, "sleeve", 6.0, 1.2, 0.2)
    _, pocket, _ = draw_joint(hull, joint)
    assert (pocket ^ hull.material).area() < 1e-3
