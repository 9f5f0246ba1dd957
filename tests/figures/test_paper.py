"""Figures for papers: their size, text and colours."""

import re

import numpy as np
import pytest

from driftform.figures.dependence import dependence_svg
from driftform.figures.files import write_picture
from driftform.figures.flight import flight_svg
from driftform.figures.gallery import GalleryEntry
from driftform.figures.overview import overview_svg
from driftform.figures.pipe import pipe_svg
from driftform.figures.reach import reach_svg
from driftform.figures.section import section_svg
from driftform.figures.strip import Strip, strip_svg
from driftform.figures.style import DASHES, Page
from driftform.figures.trend import Curve, trend_svg
from driftform.runs.coverage import PipeGrid, map_coverage
from driftform.runs.misses import Effect

TITLE = "<What> stays out & of the 'picture'"


@pytest.fixture(scope="module")
def draw(pipe, fly, make_agent):
    """Every picture of a run, by a name."""
    bodies = [make_agent(0.02 + 0.02 * i, 0.05, [0.012, 0.03 + 0.01 * i, 0.02]) for i in range(6)]
    flights = [
        GalleryEntry(name, body, fly(rise=0.02 * i - 0.05), 0.1 * i)
        for i, (name, body) in enumerate(zip(pipe.targets, bodies, strict=True))
    ]
    reach = map_coverage([(i, flight.trajectory) for i, flight in enumerate(flights)], PipeGrid.of_scenario(pipe))
    names = ("the paper's genetic algorithm: best so far", "best of each generation", "random search")
    curves = [Curve(name, np.array([1, 60, 500]), np.array([80.0, 90 + k, 99])) for k, name in enumerate(names)]
    strips = [Strip(n, 0.01, np.array([0.01, 0.1, 1.0]), 1.0) for n in pipe.targets]
    effects = [Effect("speed of the current", 0.1, ""), Effect("mass of the hull", 0.02, "")]
    return {
        "flight": lambda page: flight_svg(flights[0].trajectory, pipe, TITLE, bodies[5].body, page),
        "sideways": lambda page: flight_svg(fly(sideways=0.05), pipe, TITLE, bodies[5].body, page),
        "overview": lambda page: overview_svg(flights, pipe, TITLE, "six flights", page),
        "reach": lambda page: reach_svg(reach, pipe, TITLE, page),
        "search": lambda page: trend_svg(dict.fromkeys(pipe.targets, curves), TITLE, "Best", page),
        "robustness": lambda page: strip_svg(strips, TITLE, "Misses.", page),
        "causes": lambda page: dependence_svg(effects, TITLE, page),
        "pipe": lambda page: pipe_svg(pipe, TITLE, page=page),
        "section": lambda page: section_svg(bodies[5], TITLE, pipe, page),
    }


PICTURES = ("flight", "sideways", "overview", "reach", "search", "robustness", "causes", "pipe", "section")


@pytest.mark.parametrize("width_mm", [85.0, 180.0])
@pytest.mark.parametrize("name", PICTURES)
def test_a_figure_has_its_width_text_of_8_pt_and_no_title(read, draw, name, width_mm):
    picture = read(draw[name](Page.find(width_mm)))
    assert picture.root.get("width") == f"{width_mm:g}mm"
    assert picture.root.get("font-family").startswith("Arial")
    assert TITLE not in picture.texts
    assert picture.root.find("{http://www.w3.org/2000/svg}title").text == TITLE, "readers aloud need it"
    [width, height] = (float(v) for v in picture.root.get("viewBox").split()[2:])
    assert float(picture.root.get("height").removesuffix("mm")) == pytest.approx(width_mm * height / width, abs=0.01)
    sizes = [
        float(e.get("font-size")) * width_mm / 25.4 * 72 / width for e in picture.root.iter() if e.get("font-size")
    ]
    assert min(sizes) > 7.3 and max(sizes) < 8.7, "pt"
    assert picture.outside() == []
    assert picture.overlapping_texts() == []


@pytest.mark.parametrize("name", PICTURES)
def test_a_screen_shows_the_title_escaped_and_the_bytes_repeat(read, draw, name):
    text = draw[name](Page())
    assert TITLE in read(text).texts
    assert draw[name](Page()) == text


def test_lines_differ_in_their_dashes_on_paper_alone(read, draw):
    dashes = [line.get("stroke-dasharray") for line in read(draw["overview"](Page.find(85.0))).all("firm")]
    assert len(set(dashes)) == len(DASHES) and dashes[0] == "none"
    assert [line.get("stroke-dasharray") for line in read(draw["overview"](Page())).all("firm")] == [None] * 6


@pytest.mark.peers
def test_the_pdf_has_the_width_and_holds_its_fonts(draw, tmp_path):
    page = Page.find(85.0)
    _, pdf = write_picture(tmp_path / "flight.svg", draw["flight"](page), page)
    content = pdf.read_bytes()
    [box] = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+) [\d.]+", content)
    assert float(box) == pytest.approx(85 / 25.4 * 72, abs=0.01)
    assert b"/FontFile2" in content or b"/FontFile3" in content, "outlines of the letters used"
