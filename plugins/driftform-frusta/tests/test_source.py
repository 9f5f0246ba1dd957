"""OpenSCAD source that a person can edit, and what OpenSCAD makes of it."""

import re
from itertools import pairwise

import numpy as np
import pytest
from prints import chain_body, job_of

from driftform.agent import mass_properties
from driftform.interfaces import ExportJob
from driftform.study import load_study
from driftform.types import Agent, Coefficients
from driftform.water import Scenario
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.exporters.scad import write_source
from driftform_frusta.hull import hull_volume
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parametric import hull_source
from driftform_frusta.parts import make_parts


def agents(settings, count, seed=3):
    pipeline = load_study("paper", settings=settings, run={"seed": 0}).make_pipeline()
    rng = np.random.default_rng(seed)
    return [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(count)]


def agent_of(morphology, **options):
    body = FrustaBuilder(FrustaOptions(**options)).build(morphology)
    return Agent(body, mass_properties(body), Coefficients(np.eye(6)), morphology)


def assert_renders(agent, render, source=None):
    mesh = render(source or hull_source(agent, 64, "an agent"))
    assert mesh.volume == pytest.approx(1e9 * hull_volume(agent.body), rel=1e-4)
    assert mesh.is_watertight
    assert mesh.bounds[0, 2] == pytest.approx(0, abs=1e-3)
    assert np.ptp(mesh.vertices[:, 2]) == pytest.approx(1e3 * agent.body.length, abs=2e-3)
    assert len(mesh.split(only_watertight=True)) == 2


@pytest.mark.parametrize("settings", [[], ["grammar.occupied=skip"]], ids=["insert", "skip"])
def test_openscad_renders_the_table_of_modules_to_the_volume_that_was_simulated(settings, render):
    [agent] = agents(settings, 1)
    assert "modules = [" in hull_source(agent, 64, "")
    assert_renders(agent, render)


def test_almost_every_agent_has_a_table_of_modules():
    for settings in ([], ["grammar.occupied=skip"]):
        found = [hull_source(agent, 64, "") is not None for agent in agents(settings, 60)]
        assert sum(found) >= 58


def test_the_table_names_each_module_and_tells_its_length_and_radii():
    [agent] = agents([], 1)
    source = hull_source(agent, 64, "")
    rows = re.findall(r'\["(aft|fore) (\d+)",\s+([\d.]+),\s+([\d.]+),\s+([\d.]+)\]', source)
    aft, fore = agent.morphology.aft, agent.morphology.fore
    assert [(side, int(k)) for side, k, *_ in rows] == [
        *(("aft", k) for k in range(len(aft), 0, -1)),
        *(("fore", k + 1) for k in range(len(fore))),
    ]
    lengths = [1e3 * m.length * np.cos(m.tilt) for m in agent.morphology.modules]
    assert [float(row[2]) for row in rows] == pytest.approx(lengths, abs=1e-6)
    for before, after in pairwise(rows):
        assert before[4] == after[3]
    assert f"aft_modules = {len(aft)};" in source
    assert "wall = 1.25;" in source and "clearance = 0.2;" in source and "core_radius = 10;" in source


def test_a_thicker_wall_in_the_source_is_the_hull_with_that_wall(render):
    [agent] = agents(["grammar.occupied=skip"], 1)
    # The dome keeps to the core, so clearance gives way to the wall.
    source = hull_source(agent, 64, "").replace("wall = 1.25;", "wall = 1.35;")
    edited = source.replace("clearance = 0.2;", "clearance = 0.1;")
    assert edited != source
    thick = agent_of(agent.morphology, wall=1.35e-3, clearance=0.1e-3, min_radius=0.00245)
    assert render(edited).volume == pytest.approx(1e9 * hull_volume(thick.body), rel=1e-4)


def test_a_module_made_longer_in_the_source_makes_the_hull_longer(render):
    [agent] = agents(["grammar.occupied=skip"], 1)
    source = hull_source(agent, 64, "")
    # The outermost module of the longer side: the other side may be covered by the dome.
    rows = list(re.finditer(r'\["\w+ \d+",\s+([\d.]+)', source))
    row = rows[-1] if len(agent.morphology.fore) > len(agent.morphology.aft) else rows[0]
    edited = source[: row.start(1)] + str(float(row[1]) + 25) + source[row.end(1) :]
    longer = np.ptp(render(edited).vertices[:, 2]) - np.ptp(render(source).vertices[:, 2])
    assert longer == pytest.approx(25, abs=1e-3)


def test_the_section_is_one_half_of_the_hull(render):
    [agent] = agents(["grammar.occupied=skip"], 1)
    mesh = render(hull_source(agent, 64, "").replace("section = false;", "section = true;"))
    assert mesh.volume == pytest.approx(1e9 * hull_volume(agent.body) / 2, rel=1e-3)
    assert mesh.bounds[0, 1] == pytest.approx(0, abs=1e-3)


def test_a_body_of_another_making_is_written_as_its_contours(body, render):
    agent = Agent(body, mass_properties(body), Coefficients(np.eye(6)))
    mesh = render(
        write_source(ExportJob("stranger", agent, Scenario()), make_parts(body, PartOptions()), PartOptions())
    )
    assert mesh.volume == pytest.approx(1e9 * hull_volume(body), rel=1e-4)
    assert mesh.bounds[0, 2] == pytest.approx(0, abs=1e-3)


def test_a_table_that_would_not_render_to_the_body_is_never_written():
    [agent] = agents([], 1)
    [other] = agents([], 1, seed=4)
    mixed = Agent(agent.body, agent.mass, agent.coefficients, other.morphology)
    assert hull_source(mixed, 64, "") is None


def test_a_title_cannot_leave_its_comment():
    [agent] = agents([], 1)
    first, second, *_ = hull_source(agent, 64, "one\ncube(9); //\r\ntwo").splitlines()
    assert first.startswith("// one cube(9); // two: ")
    assert second.startswith("// Written by driftform.")


def kit_source(agent, **options):
    made = PartOptions(kit=True, segments=16, **options)
    parts = make_parts(agent.body, made)
    return parts, write_source(ExportJob("TP1", agent, Scenario()), parts, made)


def test_the_source_of_a_kit_renders_each_part_as_it_stands_on_the_bed(render):
    [agent] = agents(["grammar.occupied=skip"], 1)
    parts, source = kit_source(agent)
    assert len(parts) >= 2
    for part in parts:
        mesh = render(source.replace('part = "all";', f'part = "{part.name}";'))
        assert mesh.volume == pytest.approx(part.solid.volume, rel=1e-4)
        assert np.allclose(mesh.bounds.ravel(), part.on_bed().bounds.ravel(), atol=2e-3)


@pytest.mark.parametrize(
    "options",
    [{}, {"o_ring": 0.00178}, {"joint": "bayonet"}, {"joint": "thread"}],
    ids=["glue", "O-ring", "bayonet", "thread"],
)
@pytest.mark.parametrize("clearance", [0.1, 0.3])
def test_another_clearance_in_the_source_is_our_own_kit_of_that_clearance(options, clearance, render):
    body = chain_body("nn", "uuss")
    made = PartOptions(kit=True, segments=96, **options)
    source = write_source(job_of(body), make_parts(body, made), made)
    edited = source.replace("clearance = 0.2;", f"clearance = {clearance};")
    assert edited != source
    parts = make_parts(body, made.model_copy(update={"clearance": clearance / 1e3}))
    volume = sum(part.solid.volume for part in parts)
    assert render(edited).volume == pytest.approx(volume, rel=1e-4)
    assert abs(render(source).volume - volume) > 1e-3 * volume


def test_a_thicker_wall_and_sleeve_in_the_source_add_material_inside(render):
    body, made = chain_body("nn", "uus"), PartOptions(kit=True, segments=16)
    source = write_source(job_of(body), make_parts(body, made), made)
    plain = render(source.replace("assembled = false;", "assembled = true;"))
    for old, new in (("\nwall = 1.25;", "\nwall = 1.45;"), ("\nsleeve = 1.2;", "\nsleeve = 1.5;")):
        assert old in source
        edited = render(source.replace("assembled = false;", "assembled = true;").replace(old, new))
        assert edited.volume > 1.001 * plain.volume and edited.is_watertight
        assert np.allclose(edited.bounds, plain.bounds, atol=2e-3)


def test_the_preview_of_a_kit_is_cut_open_on_the_side_of_the_default_view(render):
    [agent] = agents(["grammar.occupied=skip"], 1)
    parts, source = kit_source(agent)
    last = parts[-1]
    preview = source.replace("$preview", "true").replace('part = "all";', f'part = "{last.name}";')
    mesh = render(preview)
    # The default view, rotated by 55 and 25 degrees, looks from (0.35, -0.74, 0.57).
    assert mesh.bounds[0, 1] == pytest.approx(0, abs=2e-3) and mesh.bounds[1, 1] > 5
    assert mesh.volume == pytest.approx(last.solid.volume / 2, rel=1e-3)
    # What is cut away covers all parts, where they stand.
    [box] = re.findall(r"translate\(\[-(\d+), -\1, -1\]\) cube\(\[\1 \+ (\d+), \1, (\d+)\]\)", source)
    reach, wide, tall = map(float, box)
    assert all(reach > part.on_bed().bounds[1, 1] and tall > part.on_bed().bounds[1, 2] for part in parts)
    places = [float(x) for x in re.findall(r", ([\d.]+), \"#", source)]
    assert wide > places[-1] + last.on_bed().bounds[1, 0]
