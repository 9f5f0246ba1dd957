"""Your own bodies: read from profiles and meshes of other programs, they are agents like any other."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from prints import job_of
from scipy.spatial.transform import Rotation
from solids import remus_body

from driftform import load_study, open_agent
from driftform.agent import mass_properties, solid_of_revolution
from driftform.errors import InputError
from driftform.motion.forces.inertia import added_mass_at
from driftform.testing.bodies import spheroid_body
from driftform.types import Morphology
from driftform.util import foreign
from driftform.water import Fluid
from driftform_frusta.exporters.meshes import StlExporter
from driftform_frusta.exporters.step import StepExporter
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.own.builder import ProfileBuilder, ProfileOptions, place_profile
from driftform_frusta.own.profile import read_profile
from driftform_panels.solve import PanelMethod, PanelOptions

BODIES = Path(__file__).parents[3] / "docs" / "bodies"
SLOPED = Rotation.from_euler("xyz", [37, -52, 11], degrees=True).as_matrix()


def write_csv(path, outer, unit="m"):
    scale = {"m": 1, "mm": 1000}[unit]
    rows = [f"{scale * (outer[-1, 0] - x):.9g},{scale * r:.9g}" for x, r in outer[::-1]]
    path.write_text("\n".join([f"x_{unit},r_{unit}", *rows]) + "\n")
    return path


def added_mass_of(outer):
    """Added mass along and across the axis, and of a turn, about the centre of the volume."""
    body = replace(spheroid_body(1, 1), outer=outer)
    coefficients = PanelMethod(PanelOptions()).coefficients(body, Fluid(density=1000.0))
    centre = np.array([solid_of_revolution(outer).centroid, 0.0, 0.0])
    return np.diag(added_mass_at(coefficients, centre))[[0, 1, 5]]


def tube(bend, radius=12.0, length=100.0, rings=13, around=32):
    """A tube along a circle that turns by ``bend``, rad, closed by flat ends; mm."""
    R = length / bend
    turn = np.linspace(0, 2 * np.pi, around, endpoint=False)
    vertices = []
    for a in np.linspace(0, bend, rings):
        middle = [R * np.sin(a), R * (1 - np.cos(a)), 0]
        across = np.array([-np.sin(a), np.cos(a), 0])
        vertices.append(middle + radius * (np.outer(np.cos(turn), across) + np.outer(np.sin(turn), [0, 0, 1])))
    ends = [vertices[0].mean(axis=0), vertices[-1].mean(axis=0)]
    k, n = np.arange(around), rings * around
    after = (k + 1) % around
    faces = [np.column_stack([np.full(around, n), k, after])]
    for i in range(0, n - around, around):
        faces += [np.column_stack([i + k, i + around + k, i + after])]
        faces += [np.column_stack([i + after, i + around + k, i + around + after])]
    faces.append(np.column_stack([np.full(around, n + 1), n - around + after, n - around + k]))
    mesh = trimesh.Trimesh(np.concatenate([*vertices, ends]), np.concatenate(faces)[:, ::-1], process=False)
    assert mesh.is_watertight and mesh.volume > 0
    return mesh


@pytest.fixture(scope="module")
def agents():
    pipeline = load_study("paper", run={"seed": 0}).make_pipeline()
    rng = np.random.default_rng(5)
    return [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(3)]


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_remus_has_the_added_mass_that_panels_find(unit, tmp_path):
    outer = remus_body(edges=400).outer
    profile = read_profile(write_csv(tmp_path / "remus.csv", outer, unit))
    assert profile.length == pytest.approx(1.3327, abs=1e-4)
    assert added_mass_of(place_profile(profile.points)) == pytest.approx(added_mass_of(outer), rel=1e-3)


def test_a_tilted_and_scaled_stl_has_the_coefficients_of_its_agent(agents, tmp_path):
    for number, agent in enumerate(agents):
        path = tmp_path / f"{number}.stl"
        StlExporter(PartOptions()).write(job_of(agent.body, "hull"), path)
        mesh = trimesh.load(path)
        mesh.vertices = 2.5 * mesh.vertices @ SLOPED.T + [300, -20, 7]
        mesh.export(path)
        profile = read_profile(path)
        assert abs(profile.axis @ SLOPED[:, 2]) == pytest.approx(1, abs=1e-9)
        assert profile.deviation < 2e-3
        found, expected = added_mass_of(place_profile(profile.points)), added_mass_of(2.5 * agent.body.outer)
        assert found == pytest.approx(expected, rel=5e-3)


@pytest.mark.peers
def test_a_step_file_has_the_coefficients_of_its_agent(agents, tmp_path):
    path = tmp_path / "agent.step"
    StepExporter(PartOptions()).write(job_of(agents[0].body, "hull"), path)
    found = added_mass_of(place_profile(read_profile(path).points))
    assert found == pytest.approx(added_mass_of(agents[0].body.outer), rel=5e-3)


@pytest.mark.peers
def test_a_step_file_of_a_ball_is_closed_at_its_poles(tmp_path):
    path = tmp_path / "ball.step"
    body = load_study("paper").make_pipeline().build(Morphology((), ()))
    StepExporter(PartOptions()).write(job_of(body, "hull"), path)
    found = added_mass_of(place_profile(read_profile(path).points))
    # Half of the water that a ball displaces moves with it.
    radius = body.outer[:, 1].max()
    assert found[:2] == pytest.approx(1000 * 2 / 3 * np.pi * radius**3, rel=5e-3)


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb"])
def test_each_format_gives_the_same_profile(suffix, tmp_path):
    mesh = trimesh.creation.capsule(height=35.0, radius=12.5, count=(64, 64))
    mesh.apply_scale(1e-3 if suffix == ".glb" else 1.0)
    mesh.export(tmp_path / f"capsule{suffix}")
    profile = read_profile(tmp_path / f"capsule{suffix}")
    assert (profile.length, 2 * profile.points[:, 1].max()) == pytest.approx((0.06, 0.025), rel=2e-3)
    volume = np.pi * 0.0125**2 * (0.035 + 4 / 3 * 0.0125)
    assert solid_of_revolution(place_profile(profile.points)).volume == pytest.approx(volume, rel=5e-3)


@pytest.mark.parametrize("height", [17.0, 1.0, 300.0])
def test_the_axis_is_found_also_where_moments_of_inertia_are_alike(height, tmp_path):
    mesh = trimesh.creation.cylinder(radius=10.0, height=height, sections=64)
    mesh.vertices = mesh.vertices @ SLOPED.T
    mesh.export(tmp_path / "cylinder.stl")
    profile = read_profile(tmp_path / "cylinder.stl")
    assert np.abs(profile.axis @ SLOPED[:, 2]) == pytest.approx(1, abs=1e-6)
    assert profile.points == pytest.approx(
        np.array([(0, 0), (0, 0.01), (height / 1000, 0.01), (height / 1000, 0)]), abs=2e-5
    )


@pytest.mark.parametrize(
    ("mesh", "least", "most"),
    [
        # In a cube the corners lie a / sqrt 2 from the axis; the circle of its section has a radius of a / sqrt pi.
        (lambda: trimesh.creation.box((40, 40, 40)), 12.6, 12.8),
        (lambda: trimesh.creation.cylinder(radius=10, height=50, sections=6), 3, 10),
        (lambda: tube(1.0), 15, 40),
        (lambda: trimesh.creation.annulus(r_min=8, r_max=10, height=50), 20, 60),
    ],
    ids=["cube", "hexagon", "bent tube", "open tube"],
)
def test_what_is_no_solid_of_revolution_is_refused_with_the_number(mesh, least, most, tmp_path):
    mesh().export(tmp_path / "part.stl")
    with pytest.raises(InputError, match=r"part\.stl: is not a solid of revolution: .* (\d+\.\d) %") as refusal:
        read_profile(tmp_path / "part.stl")
    assert least < float(str(refusal.value).partition("deviates by ")[2].partition(" %")[0]) < most


def test_a_tube_that_is_hardly_bent_is_taken_with_its_deviation(tmp_path):
    bend, length, radius = 0.02, 100.0, 12.0
    tube(bend, radius, length).export(tmp_path / "tube.stl")
    # The middle of an arc lies L bend / 8 from its chord, the ends on it, and the axis between both.
    assert 0.3 < read_profile(tmp_path / "tube.stl").deviation * 2 * radius / (length * bend / 8) < 2


def test_cavities_are_inside_and_two_solids_are_refused(tmp_path):
    ball = trimesh.creation.icosphere(3, radius=10.0)
    hollow = trimesh.util.concatenate([ball, trimesh.creation.icosphere(3, radius=8.0)])
    hollow.faces[len(ball.faces) :] = hollow.faces[len(ball.faces) :, ::-1]
    hollow.export(tmp_path / "hollow.stl")
    assert read_profile(tmp_path / "hollow.stl").points[:, 1].max() == pytest.approx(0.01, rel=1e-2)
    trimesh.util.concatenate([ball, ball.copy().apply_translation([30, 0, 0])]).export(tmp_path / "two.stl")
    with pytest.raises(InputError, match="several separate solids"):
        read_profile(tmp_path / "two.stl")
    fin = trimesh.creation.box([14.6, 14.6, 2])
    trimesh.util.concatenate([ball, fin]).export(tmp_path / "fins.stl")
    corner = np.hypot(np.hypot(7.3, 7.3), 1) - 10
    assert read_profile(tmp_path / "fins.stl").deviation == pytest.approx(corner / 20, rel=0.1)


def test_mass_centre_and_inertia_are_those_that_were_given():
    points = ((0.0, 0.0), (0.0, 0.01), (0.1, 0.02), (0.15, 0.0))
    values = {"profile": points, "mass": 0.2, "cog": 0.06}
    for inertia in (None, (2e-5, 3e-4)):
        body = ProfileBuilder(ProfileOptions(**values, inertia=inertia)).build(Morphology())
        found = mass_properties(body)
        solid = solid_of_revolution(body.outer)
        even = 0.2 / solid.volume * np.array([solid.polar, solid.transverse])
        assert found.mass == pytest.approx(0.2)
        assert body.outer[-1, 0] - found.cog[0] == pytest.approx(0.06)
        assert found.cob == pytest.approx(np.zeros(3), abs=1e-12)
        assert np.diag(found.inertia)[:2] == pytest.approx(inertia or even)


BAD_FILES = {
    "x_mm,r_cm\n0,0\n1,1\n": "its first line is 'x_mm,r_cm'; it must name the columns x_mm,r_mm or x_m,r_m",
    "x_m,r_m\n0,0\nnose,1\n": "line 3 has no two numbers: 'nose,1'",
    "x_m,r_m\n0,0\n.1,-1\n": "line 3: x must be a number, and the radius a number from 0",
    "x_m,r_m\n0,.1\n.2,.1\n.1,.1\n": "line 4: x falls to .1",
    "x_m,r_m\n0,0\n1,0\n": "it needs at least two points at different x, and a radius above 0",
    "x_m,r_m\n0,0\n1,1\n2,0\n3,1\n": "the radius is 0 between nose and tail",
    "x_m,r_m\n0,1\n1000,1\n": "is 1000 m at its largest; a body has 0.005 to 20 m: check x_mm and x_m",
    "": "its first line is ''",
}


@pytest.mark.parametrize("text", BAD_FILES)
def test_a_profile_that_is_wrong_is_refused_in_one_line(text, refused, tmp_path):
    Path("p.csv").write_text(text)
    assert f"error: p.csv: {BAD_FILES[text]}" in refused("body", "p.csv", "--mass", 1, "--cog", 0.1)


@pytest.mark.parametrize(("size", "seconds"), [(220_000, 8), (100, 5), (50_000_000, 120)])
def test_a_damaged_file_takes_its_reader_no_longer_than_its_size_deserves(monkeypatch, tmp_path, size, seconds):
    def read(function, path, seconds, memory):
        raise ValueError(f"cannot be read within {seconds:g} s")

    monkeypatch.setattr(foreign, "call_apart", read)
    (tmp_path / "part.step").write_bytes(bytes(size))
    with pytest.raises(InputError, match=rf"part\.step: cannot be read within {seconds} s"):
        read_profile(tmp_path / "part.step")


def test_wrong_options_and_files_are_refused_in_one_line(refused):
    Path("p.csv").write_text("x_m;r_m\n0;0,1\n1;0,1\n")
    Path("p.stl").write_bytes(b"\xff\0" * 100)
    Path("p.doc").write_text("")
    given = ("body", "p.csv", "--mass", 1)
    assert "--cog 3: lies past the end of p.csv, which is 1 m long" in refused(*given, "--cog", 3)
    assert "mass" in refused("body", "p.csv", "--mass", -1, "--cog", 0.1)
    assert "is not possible: about the axis at most 0.01" in refused(*given, "--cog", 0.1, "--inertia", 5, 5)
    trimesh.creation.cylinder(0.02, 0.2).export("in-metres.stl")
    assert "is 0.0002 m at its largest; a body has 0.005 to 20 m: is it in m or in? set --unit" in refused(
        "body", "in-metres.stl", "--mass", 1, "--cog", 0.1
    )
    trimesh.creation.cylinder(2, 20).export("in-cm.stl")
    assert "4e+04 kg/m3 in a body 0.02 m long, possible are 0.01 to 22600: is it 3.4 times" in refused(
        "body", "in-cm.stl", "--mass", 0.01, "--cog", 0.01
    )
    assert "--unit ft: unknown unit; choose from mm, cm, m, in" in refused(*given, "--cog", 0.1, "--unit", "ft")
    assert "p.stl: cannot be read as STL" in refused("body", "p.stl", "--mass", 1, "--cog", 0.1)
    assert "p.doc: unknown format '.doc' of a profile" in refused("body", "p.doc", "--mass", 1, "--cog", 0.1)
    assert "none.stl: no such file" in refused("body", "none.stl", "--mass", 1, "--cog", 0.1)
    assert "has one genome, without symbols" in refused("evolve", "--set", "grammar.use=fixed")


def test_the_agent_is_one_for_other_commands(done):
    write_csv(Path("capsule.csv"), spheroid_body(0.03, 0.0125).outer, "mm")
    facts = done("body", "capsule.csv", "--mass", 0.02, "--cog", 0.028, "--json")
    assert (facts["length"], facts["cob"]) == pytest.approx((0.06, 0.03), rel=1e-3)
    shown = done("inspect", "capsule.json")
    assert "modules" not in shown and "2.000 mm from the volume's" in shown
    design = open_agent("capsule.json").under("flight.horizon=1.0", use={"simulator": "native"})
    assert len(design.disturb(2).offsets) == 2
    assert done("export", "capsule.json", "--format", "stl,svg,scad", "--json")
    turned = done("body", "capsule.csv", "--mass", 0.02, "--cog", 0.028, "--flip", "--out", "back.json", "--json")
    assert turned["added_mass"] == pytest.approx(facts["added_mass"], rel=1e-3)


LAUV = ("body", BODIES / "lauv.csv", "--mass", 18, "--cog", 0.546, "--scenario", BODIES / "open-sea.toml")


def test_published_coefficients_of_lauv_replace_those_of_its_hull(done):
    """With fins, about the centre of gravity; what has no number in the paper is that of a body of revolution."""
    told = done(*LAUV, "--coefficients", BODIES / "lauv.toml", "--out", "lauv.json", "--json")
    assert told["measured"] == ["added_mass", "linear_damping", "quadratic_damping"]
    design = open_agent("lauv.json")
    found, mass = design.coefficients, design.mass
    assert np.diag(added_mass_at(found, mass.cog)) == pytest.approx([1, 16, 16, 0.005, 1.3, 1.3])
    assert np.diag(found.linear_damping) == pytest.approx([2.4, 23, 23, 0.3, 9.7, 9.7])
    assert np.diag(found.quadratic_damping) == pytest.approx([2.4, 80, 80, 0.0006, 9.1, 9.1])
    # The paper has Z_q = -11.5 and M_w = 3.1, which the file leaves out: a quarter of a turn from Y_r and N_v.
    couplings = [found.linear_damping[place] for place in ((1, 5), (5, 1), (2, 4), (4, 2))]
    assert couplings == pytest.approx((-11.5, 3.1, 11.5, -3.1))
    assert found.origin == pytest.approx(mass.cog) and found.drag is None
    along, across = (design.inspect()["terminal_speeds"][name] for name in ("along", "across"))
    force = abs(design.net_buoyancy)
    assert 2.4 * along + 2.4 * along**2 == pytest.approx(force) == 23 * across + 80 * across**2
    # Twice as dense water has twice the added mass and twice the quadratic damping.
    denser = design.under("fluid.density=2060").coefficients
    assert denser.added_mass == pytest.approx(2 * found.added_mass, abs=1e-9)
    assert denser.quadratic_damping == pytest.approx(2 * found.quadratic_damping)
    assert denser.linear_damping == pytest.approx(found.linear_damping)
    assert design.compare_added_mass().keys() == {"matrices", "panels", "striptheory"}


@pytest.mark.peers
def test_coefficients_of_an_export_are_read_back(done):
    done(*LAUV, "--coefficients", BODIES / "lauv.toml", "--out", "lauv.json")
    block = done("inspect", "lauv.json", "--block", "fossen")
    Path("again.toml").write_text(block[block.index("added_mass") : block.index("# Largest")], encoding="utf-8")
    done(*LAUV, "--coefficients", "again.toml", "--out", "again.json")
    first, again = (open_agent(name).coefficients for name in ("lauv.json", "again.json"))
    for name in ("added_mass", "linear_damping", "quadratic_damping"):
        assert getattr(again, name) == pytest.approx(getattr(first, name), abs=1e-9)


@pytest.mark.peers
def test_the_hull_keeps_what_the_file_leaves_out(done):
    Path("some.toml").write_text("origin = 0.6\nX_u = -3\nY_v = -9\nN_r = -4\n", encoding="utf-8")
    done(*LAUV, "--coefficients", "some.toml", "--out", "some.json")
    done(*LAUV, "--out", "hull.json")
    some, hull = open_agent("some.json"), open_agent("hull.json")
    cog = hull.mass.cog
    assert added_mass_at(some.coefficients, cog) == pytest.approx(added_mass_at(hull.coefficients, cog), abs=1e-9)
    assert float(hull.agent.body.outer[-1, 0] - some.coefficients.origin[0]) == pytest.approx(0.6)
    assert np.diag(some.coefficients.linear_damping) == pytest.approx([3, 9, 9, 0, 4, 4])
    assert hull.compare_added_mass().keys() == {"panels", "striptheory"}
    # Of its drag, as docs/robotics.md has it.
    block = tomllib.loads(done("inspect", "hull.json", "--block", "fossen"))
    assert np.diag(block["quadratic_damping"])[[2, 4]] == pytest.approx([63, 2.2], rel=0.02)
    assert hull.coefficients.drag is not None and some.coefficients.drag is None


def test_a_mesh_with_fins_is_taken_with_coefficients_and_a_warning_of_what_is_missing(call, refused):
    hull, span, thick = trimesh.creation.cylinder(radius=75, height=1000, sections=96), 250, 6
    fins = [trimesh.creation.box((*size, 100)) for size in ((span, thick), (thick, span))]
    for fin in fins:
        fin.apply_translation((0, 0, -400))
    trimesh.boolean.union([hull, *fins]).export("finned.stl")
    given = ("body", "finned.stl", "--mass", 17, "--cog", 0.5)
    assert "for fins, give --coefficients" in refused(*given)
    Path("some.toml").write_text("X_udot = -1\nY_vdot = -16\nM_qdot = -1.3\n", encoding="utf-8")
    made = call(*given, "--coefficients", "some.toml", "--json")
    assert made.exit_code == 0, made.stderr
    # From the circle that has the area of the section there.
    radius = np.sqrt(75**2 + 4 * 50 * thick / np.pi)
    assert json.loads(made.stdout)["deviation"] == pytest.approx((span / 2 - radius) / (2 * radius), rel=0.01)
    warning = (
        "is left out of contact; lift; linear damping, which some.toml lacks; quadratic damping, which some.toml lacks"
    )
    assert made.stderr.strip().endswith(warning)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("X_udot = -1\nY_vdot = -9\nN_rdot = -1\nN_vdot = 4\n", "added_mass is not positive"),
        ("X_udot = -1\n", "added_mass is not positive: it needs at least X_udot, Y_vdot and M_qdot"),
        ("X_udot = -1\nY_vdot = -9\nN_rdot = -9\nN_vdot = 1\nY_rdot = 2\n", "added_mass is not symmetric"),
        ("X_uu = -1\nY_vv = 1\n", "quadratic_damping drives a motion"),
        ("Y_v = -1\nN_r = -1\nN_v = 3\n", "linear_damping drives a motion"),
        ("X_uw = -1\n", "'X_uw': expected a name such as Y_vdot"),
        ("X_u = nan\n", "'X_u': Input should be a finite number"),
        ("linear_damping = [[1, 2], [3, 4]]\n", "'linear_damping.0.2': Field required"),
    ],
)
def test_coefficients_that_no_body_has_are_refused_in_one_line(text, message, refused):
    Path("odd.toml").write_text(text, encoding="utf-8")
    assert f"error: odd.toml: {message}" in refused(*LAUV, "--coefficients", "odd.toml", "--out", "odd.json")
