"""A capsule as the core: its file, the hull around it, and what both weigh."""

import numpy as np
import pytest
import trimesh

from driftform.agent import MassElement, distance_from, mass_properties, solid_of_revolution
from driftform.errors import InputError
from driftform.study import Document, load_study
from driftform.testing.builder import MORPHOLOGIES
from driftform.types import Agent, Coefficients, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.cores import CORES

R, LONG, MASS, COG = 0.0125, 0.06, 0.025, 0.034
"""Radius, length, mass and centre of gravity from the nose of a capsule with round ends."""


def capsule(step=5.0):
    angle = np.deg2rad(np.arange(0, 90 + step / 2, step))
    nose = np.column_stack((R - R * np.cos(angle), R * np.sin(angle)))
    return np.concatenate((nose, (nose * (-1, 1) + (LONG, 0))[::-1])).round(9)


def ball():
    angle = np.deg2rad(np.arange(0, 180.1, 2.5))
    return np.column_stack((0.01 - 0.01 * np.cos(angle), 0.01 * np.sin(angle)))


def write_csv(path, points):
    rows = "\n".join(f"{1000 * x:.9f},{1000 * r:.9f}" for x, r in points)
    path.write_text(f"x_mm,r_mm\n{rows}\n")
    return path


def around(path, points, **options):
    given = {"core_mass": MASS, "core_cog": COG, **options}
    return FrustaBuilder(FrustaOptions(core=str(write_csv(path / "core.csv", points)), **given))


def weigh_mesh(contour, density=None, mass=None):
    """Mass, x of the centre, and inertia about it along and across the axis, of a mesh of 512 sections."""
    # In mm, because small triangles are dropped.
    mesh = trimesh.creation.revolve(1000 * np.asarray(contour)[:, ::-1], sections=512)
    assert mesh.volume > 0
    mesh.density = 1e-9 * density if density else mass / mesh.volume
    inertia = 1e-6 * np.diag(mesh.moment_inertia)
    return mesh.mass, 1e-3 * mesh.center_mass[2], inertia[2], inertia[0]


@pytest.mark.parametrize("kind", ["no module", "all fore", "zigzag"])
@pytest.mark.parametrize("wall_model", ["mitred", "paper"])
def test_mass_and_inertia_are_those_of_the_meshes_of_hull_and_capsule(kind, wall_model, tmp_path):
    body = around(tmp_path, capsule(), wall_model=wall_model).build(MORPHOLOGIES[kind]())
    nose = LONG / 2
    outside, cavity = weigh_mesh(body.outer, 1050.0), weigh_mesh(body.cavity, 1050.0)
    core = weigh_mesh([(x - nose, r) for x, r in capsule()], mass=MASS)
    parts = [(1, outside), (-1, cavity), (1, (core[0], nose - COG, *core[2:]))]
    mass = sum(sign * m for sign, (m, *_) in parts)
    cog = sum(sign * m * x for sign, (m, x, *_) in parts) / mass
    axial = sum(sign * a for sign, (_, _, a, _) in parts)
    transverse = sum(sign * (t + m * (x - cog) ** 2) for sign, (m, x, _, t) in parts)
    found = mass_properties(body)
    # A mesh of 512 sections lacks 2.5e-5 of each area, and a hull is the difference of two.
    assert found.mass == pytest.approx(mass, rel=5e-5)
    assert found.cog[0] == pytest.approx(cog, abs=2e-6)
    assert np.diag(found.inertia) == pytest.approx([axial, transverse, transverse], rel=2e-4)
    assert found.volume == pytest.approx(outside[0] / 1050, rel=5e-5)


def test_a_print_weighs_as_simulated_when_hull_and_capsule_are_put_together(tmp_path):
    body = around(tmp_path, capsule()).build(MORPHOLOGIES["all fore"]())
    agent = Agent(body, mass_properties(body), Coefficients(np.eye(6)))
    elements = MassElement.of_print(body, agent.mass.mass)
    again = MassElement.reweigh(agent, elements).mass
    assert again.cog == pytest.approx(agent.mass.cog, abs=1e-12)
    assert again.inertia == pytest.approx(agent.mass.inertia, rel=1e-9)
    measured = MassElement.of_print(body, agent.mass.mass, agent.mass.cog[0])
    assert measured[0].x == pytest.approx(elements[0].x, abs=1e-12)


@pytest.mark.parametrize("kind", ["no module", "zigzag", "39 random modules (1)"])
def test_a_ball_by_its_profile_is_the_ball(kind, tmp_path):
    morphology = MORPHOLOGIES[kind]()
    other = around(tmp_path, ball(), core_mass=0.05, core_cog=0.01).build(morphology)
    same = FrustaBuilder(FrustaOptions()).build(morphology)
    # A chord of 2.5 degrees lies 2.4e-4 of the radius within the circle.
    assert distance_from(same.outer, other.outer).max() < 4e-6
    assert distance_from(same.cavity, other.cavity).max() < 6e-6
    a, b = mass_properties(same), mass_properties(other)
    assert b.mass == pytest.approx(a.mass, rel=2e-4)
    assert b.cog[0] == pytest.approx(a.cog[0], abs=2e-6)
    assert b.inertia == pytest.approx(a.inertia, rel=5e-4)


def test_a_waist_gets_the_room_of_what_passes_it(tmp_path):
    waist = np.array([(0, 0), (0, 0.01), (0.02, 0.01), (0.03, 0.006), (0.04, 0.0125), (0.05, 0.0125), (0.05, 0)])
    core = around(tmp_path, waist).build(Morphology()).core
    # Its widest part, 40 to 50 mm from the nose, has its middle at the origin.
    assert core.ends == pytest.approx((-0.005, 0.045), abs=1e-9)
    assert core.radius_at(0.045 - np.array([0.03, 0.01])) == pytest.approx([0.01, 0.01], abs=1e-9)
    assert core.volume == pytest.approx(solid_of_revolution(waist).volume, rel=1e-6)


def study_in(folder, extra=""):
    folder.mkdir()
    write_csv(folder / "core.csv", capsule())
    path = folder / "study.toml"
    path.write_text(f'base = "pipe-inspection"\n[builder]\ncore = "core.csv"\n{extra}')
    return path


def test_a_study_finds_the_file_beside_it_and_needs_it_no_more(tmp_path):
    path = study_in(tmp_path / "there", "core_mass = 0.025\ncore_cog = 0.034\n")
    study = load_study(str(path), run={"seed": 0})
    assert str(tmp_path) not in str(study.document)
    (tmp_path / "there" / "core.csv").unlink()
    again = load_study(Document("resolved", study.document))
    assert again.document["builder"] == study.document["builder"]
    assert again.document["builder"]["core_radius"] == R
    # The size of a capsule does not stay if a ball takes its place.
    steel = load_study(Document("resolved", study.document), ['builder.core="steel-20mm"']).document["builder"]
    assert steel["core_mass"] == CORES["steel-20mm"].mass and not steel["core_profile"]


@pytest.mark.parametrize(
    "extra, message",
    [
        ("core_cog = 0.03", r"study.toml:3: 'core' is the file of a capsule, whose core_mass is missing: add it"),
        ("core_mass = 0.02", r"study.toml:3: .*core_cog is missing: add it"),
        ("core_mass = 0.02\ncore_cog = 0.07", r"study.toml:5: 'core_cog' is 0.07 m from the nose, and .* 0.06 m"),
    ],
)
def test_a_capsule_without_mass_or_balance_is_one_line(extra, message, tmp_path):
    with pytest.raises(InputError, match=message) as refusal:
        load_study(str(study_in(tmp_path / "there", extra)))
    assert len(refusal.value.args) == 1


def test_a_file_that_is_not_there_is_one_line(tmp_path):
    settings = [f'builder.core="{tmp_path}/core.csv"', "builder.core_mass=1", "builder.core_cog=0"]
    with pytest.raises(InputError, match=r"core.csv: no such file"):
        load_study("pipe-inspection", settings)
