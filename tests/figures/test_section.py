import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.figures.layout import MINUS
from driftform.figures.section import hatch, section_svg
from driftform.types import Agent, Body, Coefficients, Core, MassProperties


@pytest.fixture(scope="module")
def bare():
    angles = np.linspace(0, np.pi, 41)
    sphere = np.column_stack([-np.cos(angles), np.sin(angles)])
    body = Body(0.01145 * sphere, 0.0102 * sphere, [0.0], Core(0.01, 0.05), 0.00125, 1050.0)
    return Agent(body, MassProperties(0.052, np.zeros(3), np.eye(3), 6e-6, np.zeros(3)), Coefficients(np.eye(6)))


def printed_mm_per_px(picture):
    return float(picture.root.get("width").removesuffix("mm")) / picture.size[0]


@settings(deadline=None, max_examples=40)
@given(data=st.data())
def test_printed_at_its_size_the_outline_is_to_the_stated_scale_and_has_its_dimensions(read, points, agents, data):
    agent = data.draw(agents)
    picture = read(section_svg(agent))
    paper, body = re.fullmatch(r"Scale (\d+) : (\d+)", picture.one("scale").text).groups()
    scale = int(paper) / int(body)
    drawn = np.ptp(points(picture.one("outline")), axis=0) * printed_mm_per_px(picture)
    true = 1000 * np.array([agent.body.length, agent.body.max_diameter])
    assert drawn == pytest.approx(true * scale, abs=0.02)
    bar = np.ptp(points(picture.one("scale-bar"))[:, 0]) * printed_mm_per_px(picture)
    assert bar == pytest.approx(float(picture.one("scale-bar-label").text.removesuffix(" mm")) * scale, abs=0.02)

    assert picture.one("length").text == f"{1000 * agent.body.length:.1f} mm"
    assert picture.one("diameter").text == f"Ø {1000 * agent.body.max_diameter:.1f} mm"


def test_wall_and_core_are_dimensioned(read, bare, make_agent):
    for agent in (bare, make_agent(0.08, 0.08, [0.03, 0.02, 0.03])):
        picture = read(section_svg(agent))
        assert picture.one("wall-label").text == "wall 1.25 mm"
        assert picture.one("core-label").text == "core Ø 20 mm"


def test_each_joint_between_modules_has_a_tick_below_the_length(read, points, make_agent):
    agent = make_agent(0.04, 0.06, [0.02, 0.03, 0.02, 0.025, 0.02])
    picture = read(section_svg(agent))
    ticks = points(picture.one("ticks")).reshape(-1, 2, 2)
    outline = points(picture.one("outline"))
    left, right = outline[:, 0].min(), outline[:, 0].max()
    assert (ticks[:, 0, 0] - left) / (right - left) == pytest.approx([0.25, 0.5, 0.75], abs=1e-3)
    assert (ticks[:, 1, 1] > ticks[:, 0, 1]).all()


def test_the_title_block_has_mass_and_volume(read, make_agent):
    agent = make_agent(0.08, 0.08, [0.03, 0.02, 0.03])
    cells = [e.text for e in read(section_svg(agent)).all("cell")]
    assert f"{1000 * agent.mass.mass:.1f} g" in cells
    assert f"{1e6 * agent.mass.volume:.1f} cm³" in cells
    assert "50.0 g" in cells


def test_the_fore_end_is_on_the_right_and_the_core_at_the_origin(read, points, make_agent):
    agent = make_agent(0.02, 0.08, [0.02, 0.02, 0.03])
    picture = read(section_svg(agent))
    outline = points(picture.one("outline"))
    left, right = outline[:, 0].min(), outline[:, 0].max()
    core = points(picture.one("core")).mean(axis=0)
    assert (core[0] - left) / (right - left) == pytest.approx(0.2, abs=1e-3)
    widest = outline[np.argmin(outline[:, 1])]
    assert widest[0] == pytest.approx(right)


@pytest.mark.parametrize("distance", [0.0, 1e-5, 0.001, 0.03])
def test_the_centres_are_marked_where_they_are_and_their_labels_keep_apart(read, points, make_agent, distance):
    agent = make_agent(0.08, 0.08, [0.03, 0.02, 0.03])
    mass = replace(agent.mass, cog=[0.01, 0, 0], cob=[0.01 - distance, 0, 0])
    picture = read(section_svg(replace(agent, mass=mass)))
    outline = points(picture.one("outline"))
    px_per_m = np.ptp(outline[:, 0]) / agent.body.length
    middle = (outline[:, 0].min() + outline[:, 0].max()) / 2
    for name, x in (("cog", 0.01), ("cob", 0.01 - distance)):
        marks = [points(e).mean(axis=0) for e in picture.all(name) if e.get("r")]
        assert any(abs(mark[0] - middle - x * px_per_m) < 0.02 for mark in marks)
        assert f"{name.upper()} x = {1000 * x:.1f} mm".replace("-", MINUS) in picture.texts
    assert picture.overlapping_texts() == []


def test_hatching_covers_the_wall_and_not_the_hole():
    square = np.array([[0.0, 0], [100, 0], [100, 100], [0, 100]])
    hole = 20 + 0.6 * square
    pieces = hatch([square, hole], 0.5)
    length = sum(np.linalg.norm(b - a) for a, b in pieces)
    assert 0.5 * length == pytest.approx(100**2 - 60**2, rel=1e-3)
    middles = np.array([(a + b) / 2 for a, b in pieces])
    assert not ((middles > 20.5) & (middles < 79.5)).all(axis=1).any()
