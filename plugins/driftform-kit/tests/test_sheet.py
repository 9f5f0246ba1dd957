"""The assembly sheet of a kit: its numbers, its order, its scale and its page."""

import math
import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from prints import chain_body, job_of, weigh_meshes

from driftform.agent import mass_properties
from driftform.errors import WorkFailedError
from driftform.figures.layout import text_width
from driftform.interfaces import ExportJob
from driftform.types import Agent, Coefficients, Core, Module, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.exporters.meshes import StlExporter
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_kit.sheet.contents import plan_sheet
from driftform_kit.sheet.drawing import draw_pages

NAMESPACE = "{http://www.w3.org/2000/svg}"
A4 = (210.0, 297.0)
TILTS = st.sampled_from([-0.3, 0.0, 0.3])
SIDES = st.lists(st.builds(Module, st.sampled_from([0.005, 0.01]), TILTS), max_size=30).map(tuple)
BODIES = st.builds(lambda fore, aft: FrustaBuilder(FrustaOptions()).build(Morphology(fore, aft)), SIDES, SIDES)


def straight(fore, aft, **options):
    return chain_body("s" * fore, "s" * aft, **options)


def sheet_of(body, **options):
    return plan_sheet(job_of(body, "r1-TP5"), PartOptions(kit=True, **options))


def numbers(path):
    """The points of path data of straight lines, (n, 2)."""
    return np.array(re.findall(r"-?[\d.]+", path), dtype=float).reshape(-1, 2)


def find(root, kind, tag="path"):
    return [element for element in root.iter(NAMESPACE + tag) if element.get("class") == kind]


@pytest.mark.parametrize("options", [{}, {"lap": 0.007}, {"joint": "rabbet"}])
def test_the_parts_of_the_sheet_weigh_what_their_meshes_weigh(options):
    body = straight(6, 4)
    parts = make_parts(body, PartOptions(kit=True, **options))
    grams = {part.name: 1e-6 * part.solid.volume * body.hull_density for part in parts}
    sheet = sheet_of(body, **options)
    assert {part.piece.name: 1e3 * part.mass for part in sheet.parts} == pytest.approx(grams, rel=1e-4)
    table = {name: full for name, full, _ in sheet.weights}
    assert table["core"] == 0.05
    assert table["closed kit"] == pytest.approx(1e-3 * sum(grams.values()) + 0.05, rel=1e-6)
    assert table["as simulated"] == mass_properties(body).mass


@settings(max_examples=12, deadline=None)
@given(BODIES, st.sampled_from([0.21, 0.09]))
def test_each_part_is_joined_to_one_that_is_in_place_already(body, height):
    try:
        sheet = sheet_of(body, bed=(0.25, 0.21, height))
    except WorkFailedError as error:
        assert "no kit can be made" in str(error)
        return
    assert sorted(part.place for part in sheet.parts) == list(range(len(sheet.parts)))
    assert [part.number for part in sheet.parts] == list(range(1, len(sheet.parts) + 1))
    in_place = {sheet.parts[0].place}
    [core] = [index for index, step in enumerate(sheet.steps) if "Lay the core" in step]
    assert f"the {sheet.parts[0].piece.name}." in sheet.steps[core]
    for part, step in zip(sheet.parts[1:], sheet.steps[core + 1 :], strict=False):
        other = int(re.search(r"to part (\d+)", step).group(1))
        neighbour = sheet.parts[other - 1].place
        assert step.startswith(f"Join part {part.number}, the {part.piece.name}, to part {other}")
        assert neighbour in in_place and abs(neighbour - part.place) == 1
        joint = sheet.kit.joints[min(neighbour, part.place)]
        assert f"at {joint.z - 1e3 * body.outer[0, 0]:.1f}\u00a0mm" in step
        in_place.add(part.place)
    # The core is inside once the first two parts are joined.
    assert {sheet.parts[0].piece.name, sheet.parts[1].piece.name} == {"aft shell", "fore shell"}


@settings(max_examples=8, deadline=None)
@given(BODIES)
def test_drawings_have_the_scale_that_the_sheet_states(body):
    sheet = sheet_of(body)
    root = ET.fromstring(draw_pages(sheet)[0])
    assert (root.get("width"), root.get("height")) == ("210mm", "297mm")
    mm = A4[0] / float(root.get("viewBox").split()[2])
    closed, printed = (
        tuple(float(n) for n in re.search(r"scale ([\d.]+) : ([\d.]+)", heading.text).groups())
        for heading in find(root, "heading", "text")
        if "scale" in heading.text
    )
    drawn = [numbers(path.get("d")) for path in find(root, "part")]
    half = len(drawn) // 2
    length = np.ptp(np.concatenate(drawn[:half])[:, 0]) * mm * closed[1] / closed[0]
    assert length == pytest.approx(1e3 * body.length, abs=0.02 * closed[1])
    for part, both in zip(sheet.parts, drawn[half:], strict=True):
        width, height = np.ptp(both, axis=0) * mm * printed[1] / printed[0]
        assert (width, height) == pytest.approx(part.size, abs=0.02 * printed[1])


@settings(max_examples=12, deadline=None)
@given(BODIES, st.sampled_from([{}, {"bed": (0.25, 0.21, 0.1)}]))
def test_nothing_is_drawn_beside_the_page(body, options):
    try:
        sheet = sheet_of(body, **options)
    except WorkFailedError as error:
        assert "no kit can be made" in str(error)
        return
    for root in map(ET.fromstring, draw_pages(sheet)):
        width, height = map(float, root.get("viewBox").split()[2:])
        for path in root.iter(NAMESPACE + "path"):
            points = numbers(path.get("d"))
            assert (points >= 0).all() and (points <= (width, height)).all()
        for text in root.iter(NAMESPACE + "text"):
            size, x, y = (float(text.get(name)) for name in ("font-size", "x", "y"))
            long = text_width(text.text, size, text.get("font-weight") is not None)
            low = {"start": x, "middle": x - long / 2, "end": x - long}[text.get("text-anchor", "start")]
            assert low >= 0 and low + long <= width and size <= y <= height, text.text


def weigh_kit(body, **options):
    """Mass (kg) and moment (kg m) of the printed parts and the balls of a kit, from meshes and balls alone."""
    o = PartOptions(kit=True, **options)
    mass, cog, _ = weigh_meshes(body, o)
    balls = [(math.pi / 6 * o.ballast_density * d**3, x) for x, d in o.ballast]
    return mass - body.core.mass, mass * cog[0], sum(m for m, _ in balls), sum(m * x for m, x in balls)


def read_flow(text):
    """The flow that a text advises, over the full flow."""
    return 1 - float(re.search(r"([\d.]+)\u00a0% less", text).group(1)) / 100


@pytest.mark.parametrize("made_as", ["hull", "kit"])
def test_the_parts_are_printed_a_twentieth_lighter_than_the_simulated_agent_needs_them(made_as):
    body = straight(6, 4, made_as=made_as)
    sheet = sheet_of(body)
    printed, moment, _, _ = weigh_kit(body)
    wanted = mass_properties(body)
    flow = read_flow(sheet.remedy)
    assert flow == pytest.approx(0.95 * (wanted.mass - 0.05) / printed, abs=1e-3)
    assert read_flow(sheet.steps[0]) == flow
    # What is missing then has the mass and the moment that trim adds as ballast.
    lack = wanted.mass - 0.05 - sheet.flow * printed
    assert f"lacks {1e3 * lack:.2f}\u00a0g" in sheet.remedy
    x = (wanted.mass * wanted.cog[0] - sheet.flow * moment) / lack - body.outer[0, 0]
    assert f"centred at {1e3 * x:.1f}\u00a0mm" in sheet.remedy
    assert f"should weigh {1e3 * sheet.flow * printed:.2f}\u00a0g together" in sheet.steps[2]
    assert f"more than {1e3 * (wanted.mass - 0.05):.2f}\u00a0g, print them again" in sheet.steps[2]


def test_however_much_the_sheet_says_its_parts_are_drawn_to_a_scale_that_can_be_read():
    options = {
        "ballast": [[0.1, 0.007]],
        "ballast_density": 7850.0,
        "bed": (0.22, 0.22, 0.12),
        "o_ring": 0.0015,
        "sleeve": 0.0016,
        "lap": 0.008,
    }
    job = job_of(straight(22, 12, core="steel-20mm"))
    opened = "runs/pipe-inspection-12:TP10 --set builder.core=steel-20mm"
    named = ExportJob("pipe-inspection-12-TP10", job.agent, job.scenario, {}, opened)
    pages = draw_pages(plan_sheet(named, PartOptions(kit=True, **options)))
    for part, whole in re.findall(r"scale ([\d.]+) : ([\d.]+)", pages[0]):
        assert float(part) / float(whole) >= 1 / 5
    for root in map(ET.fromstring, pages):
        assert min(float(text.get("font-size")) for text in root.iter(NAMESPACE + "text")) >= 9


def test_a_kit_that_is_too_light_states_the_ballast_that_gives_mass_and_balance():
    body = straight(6, 4)
    heavier = body.__class__(**{**vars(body), "core": Core(0.01, 0.055)})
    job = job_of(body)
    heavy = ExportJob(job.name, Agent(body, mass_properties(heavier), Coefficients(np.eye(6))), job.scenario)
    sheet = plan_sheet(heavy, PartOptions(kit=True))
    assert sheet.flow == 1 and "flow" not in sheet.remedy + sheet.steps[0]
    grams = float(re.search(r"lacks ([\d.]+)\u00a0g", sheet.remedy).group(1))
    x = float(re.search(r"centred at (-?[\d.]+)\u00a0mm", sheet.remedy).group(1)) + 1e3 * body.outer[0, 0]
    printed, printed_moment, _, _ = weigh_kit(body)
    target = sheet.target
    assert 1e3 * (printed + 0.05) + grams == pytest.approx(1e3 * target.mass, abs=0.01)
    moment = 1e6 * printed_moment + grams * x
    assert moment == pytest.approx(1e6 * target.mass * target.cog[0], abs=0.06 * grams + 0.005 * abs(x))


def test_the_sheet_names_core_and_seal():
    body = straight(8, 8, core="steel-20mm", clearance=0.006)
    ring = sheet_of(body, o_ring=0.0015)
    text = " ".join(ring.steps)
    assert "steel-20mm: ball of 20 mm, 32.80\u00a0g" in text
    assert "O-ring of 1.5\u00a0mm cord" in text and "glue" not in text
    # The bore is 16 mm in radius, less what its chamfer needs; a gland of .749 cords, as for that of 1.78 mm, is 1.124 mm deep.
    assert "bottom 29.8\u00a0mm across, 0.8\u00a0mm of wall below it" in text
    # Stretched by 5 and by 1 %.
    assert dict(ring.shopping)["O-rings"] == "1 of 1.5\u00a0mm cord, 28.4 to 29.5\u00a0mm inside, and grease"
    glued = sheet_of(straight(8, 8))
    assert [dict(sheet.shopping)["glue"].rpartition(", ")[2] for sheet in (ring, glued)] == ["for leaks", "for 1 joint"]
    assert "O-ring" not in " ".join(glued.steps)


def test_ballast_with_a_seat_goes_in_before_its_part_is_joined():
    sheet = sheet_of(straight(6, 4), ballast=[[0.045, 0.008]])
    [held] = sheet.kit.ballast
    [number] = [part.number for part in sheet.parts if part.place == held.part]
    [step] = [i for i, text in enumerate(sheet.steps) if "ball A, a steel ball of 8.00\u00a0mm" in text]
    joined = [i for i, text in enumerate(sheet.steps) if re.match(rf"(Join|Lay).* part {number}", text)]
    assert step < joined[0]
    assert f"into part {number} by its aft end" in sheet.steps[step]
    assert f"at {1e3 * (0.045 - sheet.kit.hull.skin[0, 0] / 1e3):.1f}\u00a0mm" in sheet.steps[step]

    root = ET.fromstring(draw_pages(sheet)[0])
    [ball], [core] = find(root, "ballast", "circle"), find(root, "core", "circle")
    assert float(ball.get("r")) / float(core.get("r")) == pytest.approx(4 / 10, rel=1e-2)
    assert (float(ball.get("cx")) - float(core.get("cx"))) / float(core.get("r")) == pytest.approx(4.5, rel=1e-2)


@pytest.mark.peers
@pytest.mark.parametrize("number", [1, 2])
def test_with_the_extra_each_page_is_one_of_a4_as_pdf_too(tmp_path, number):
    pytest.importorskip("cairosvg")
    StlExporter(PartOptions(kit=True)).write(job_of(straight(3, 2)), tmp_path / "a.stl")
    data = (tmp_path / f"a-assembly-{number}.pdf").read_bytes()
    assert data.startswith(b"%PDF-")
    [box] = re.findall(rb"/MediaBox \[ ([\d. ]+) \]", data)
    points = 72 / 25.4
    assert [float(n) for n in box.split()] == pytest.approx([0, 0, 210 * points, 297 * points], abs=0.1)
    # Drawn as lines and text, not as a picture.
    assert b"/Subtype /Image" not in data


@pytest.mark.parametrize(("density", "material"), [(11_340.0, "lead"), (7850.0, "steel"), (5000.0, "5000 kg/m3")])
def test_the_sheet_weighs_the_ball_and_names_its_size_and_material(density, material):
    body = straight(6, 5)
    sheet = sheet_of(body, ballast=[[0.045, 0.008]], ballast_density=density)
    table, text = {name: full for name, full, _ in sheet.weights}, " ".join(sheet.steps)
    mass = math.pi / 6 * density * 0.008**3
    assert table["ball A"] == pytest.approx(mass)
    assert f"ball A, a {material} ball of 8.00\u00a0mm, {1e3 * mass:.2f}\u00a0g" in text
    printed = weigh_kit(body, ballast=[[0.045, 0.008]])[0]
    assert table["closed kit"] == pytest.approx(printed + 0.05 + mass, rel=1e-6)


@pytest.mark.parametrize("balls", [[[0.045, 0.008]], [[-0.045, 0.0095]]])
def test_with_their_ballast_the_parts_of_the_sheet_weigh_and_balance_as_simulated(balls):
    body = straight(8, 7, made_as="kit")
    sheet = sheet_of(body, ballast=balls)
    printed, moment, ballast, ballast_moment = weigh_kit(body, ballast=balls)
    wanted = mass_properties(body)
    # The ballast makes up for parts that were printed and weighed lighter: they are to be printed so again.
    assert sheet.flow * printed + 0.05 + ballast == pytest.approx(wanted.mass, rel=1e-6)
    assert f"for parts that weigh {1e3 * sheet.flow * printed:.2f}\u00a0g together" in sheet.remedy
    assert read_flow(sheet.remedy) == pytest.approx(sheet.flow, abs=6e-4)
    assert "% less flow" not in sheet.remedy + sheet.steps[0]
    assert "the flow of the parts that were weighed for the ballast" in sheet.steps[0]
    x = (sheet.flow * moment + ballast_moment) / wanted.mass - body.outer[0, 0]
    assert f"balances at {1e3 * x:.1f}\u00a0mm" in sheet.remedy
    advised = {name: mass for name, _, mass in sheet.weights}
    assert advised["closed kit"] == pytest.approx(wanted.mass, rel=1e-6)
    parts = [mass for name, mass in advised.items() if name[0].isdigit()]
    assert sum(parts) == pytest.approx(sheet.flow * printed, rel=1e-4)


def test_everything_goes_in_before_anything_is_closed():
    narrow, wide = (Module(0.01, tilt) for tilt in (-math.radians(20), math.radians(20)))
    body = FrustaBuilder(FrustaOptions()).build(
        Morphology((*[narrow] * 3, *[wide] * 3, Module(0.02, 0.0)), (Module(0.01, 0.0),) * 5)
    )
    first = (
        "Print the parts",
        "While part",
        "Test each part",
        "Weigh the loose",
        "Trim",
        "Put ball",
        "Lay the core",
        "Join",
    )
    order = (*first, "Weigh the closed", "Weigh it in water")
    for ball, left_out in (([-0.04, 0.006], "While part"), ([0.065, 0.010], "Put ball")):
        sheet = sheet_of(body, ballast=[ball])
        found = [next(word for word in order if step.startswith(word)) for step in sheet.steps]
        assert found == [word for word in order if word != left_out]
    [held] = sheet.kit.ballast
    [part] = [part for part in sheet.parts if part.place == held.part]
    inside = 1e3 * math.pi / 6 * 7850 * 0.010**3
    assert (
        held.mouth is None and f"Take {inside:.2f}\u00a0g off part {part.number} for ball A inside." in sheet.steps[3]
    )


def test_what_to_get_is_enough_for_the_parts_and_the_scale_for_the_agent():
    body = straight(6, 5, core="steel-20mm")
    sheet = sheet_of(body, ballast=[[0.05, 0.008]])
    shopping = dict(sheet.shopping)
    grams = 1.1e3 * sum(part.mass for part in sheet.parts)
    assert grams <= float(shopping["filament"].split("\u00a0")[0]) < grams + 1
    assert shopping["core"].startswith("steel-20mm") and "ball A, a steel ball of 8.00" in shopping["ballast"]
    assert int(shopping["scale"].split()[1]) > 1e3 * sheet.target.mass
    # Trim computes ballast that is not known yet.
    light = sheet_of(straight(6, 4))
    assert re.search(r"lacks ([\d.]+)", light.remedy).group(1) in dict(light.shopping)["ballast"]


def test_each_step_has_a_drawing_of_the_parts_that_it_names():
    body = straight(22, 12, core="steel-20mm")
    sheet = sheet_of(body, ballast=[[-0.06, 0.006]], bed=(0.22, 0.22, 0.12))
    assert len(sheet.steps) == len(sheet.scenes) == len(set(sheet.scenes))
    root = ET.fromstring(draw_pages(sheet)[1])
    rules = [numbers(path.get("d"))[0, 1] for path in find(root, "rule")]
    shapes = [numbers(path.get("d"))[:, 1].mean() for path in find(root, "scene")]
    marks = [(float(text.get("y")), text.text) for text in find(root, "number", "text")]
    for low, high, scene, step in zip([0.0, *rules], rules, sheet.scenes, sheet.steps, strict=False):
        assert any(low < y < high for y in shapes), scene
        drawn = {mark for y, mark in marks if low < y < high}
        assert set(re.findall(r"[Pp]art (\d)", step)) <= drawn or scene == "test", scene
        if scene.startswith("join"):
            assert drawn == {str(n) for n in range(1, int(scene[-1]) + 1)}


def test_the_sheet_says_what_the_material_needs_in_water_and_which_walls_let_it_in():
    resin = dict(sheet_of(straight(3, 2, material="resin")).shopping)["filament"]
    assert "of resin, 1.15\u00a0g/cm³" in resin and "varnish the parts" in resin
    # Two lines on either side fill a wall of 1.25 mm, one does not.
    filled = {(n, share): sheet_of(straight(3, 2), perimeters=n, infill=share) for n in (1, 2) for share in (0.5, 1.0)}
    creeps = {key: "set infill to 1, or perimeters to 2" in sheet.steps[0] for key, sheet in filled.items()}
    assert creeps == {(1, 0.5): True, (1, 1.0): False, (2, 0.5): False, (2, 1.0): False}
