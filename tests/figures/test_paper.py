"""Figures for papers: their size, text and colours."""

import re
from collections.abc import Callable
from itertools import combinations

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
from driftform.figures.style import DASHES, SERIES, Page
from driftform.figures.trend import Curve, trend_svg
from driftform.runs.coverage import PipeGrid, map_coverage
from driftform.runs.misses import Effect

TITLE = "<What> stays out & of the 'picture'"

# Machado, Oliveira and Fernandes (2009), IEEE TVCG 15(6), table 1, severity 1.0: linear RGB as others see it.
SEEN = {
    "anyone": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
}


@pytest.fixture(scope="module")
def draw(pipe, fly, make_agent) -> dict[str, Callable[[Page], str]]:
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
def test_a_figure_has_its_width_text_of_8_pt_and_no_title(read, draw, name: str, width_mm: float) -> None:
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
def test_a_screen_shows_the_title_escaped_and_the_bytes_repeat(read, draw, name: str) -> None:
    text = draw[name](Page())
    assert TITLE in read(text).texts
    assert draw[name](Page()) == text


def see(colour: str, matrix) -> np.ndarray:
    """A colour in CIELAB (D65, IEC 61966-2-1), as it is seen with a matrix of linear RGB."""
    channels = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    xyz = [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.072175], [0.0193339, 0.119192, 0.9503041]]
    part = np.array(xyz) @ np.clip(np.array(matrix) @ linear, 0, 1) / (0.95047, 1, 1.08883)
    f = np.where(part > 0.008856, np.cbrt(part), 7.787 * part + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("sight", SEEN)
def test_series_with_the_same_dashes_differ_in_colour_for_anyone(sight: str) -> None:
    apart = {
        (i, j): float(np.linalg.norm(see(a, SEEN[sight]) - see(b, SEEN[sight])))
        for (i, a), (j, b) in combinations(enumerate(SERIES), 2)
    }
    same = {pair: distance for pair, distance in apart.items() if (pair[0] - pair[1]) % len(DASHES) == 0}
    print(sight, f"all: {min(apart.values()):.1f}, same dashes: {min(same.values()):.1f}")
    # A difference of 2.3 is just noticeable; 20 is as far as two shades of a map are apart.
    assert min(same.values()) > 20
    assert min(apart.values()) > 5


def test_lines_differ_in_their_dashes_on_paper_alone(read, draw) -> None:
    dashes = [line.get("stroke-dasharray") for line in read(draw["overview"](Page.find(85.0))).all("firm")]
    assert len(set(dashes)) == len(DASHES) and dashes[0] == "none"
    assert [line.get("stroke-dasharray") for line in read(draw["overview"](Page())).all("firm")] == [None] * 6


@pytest.mark.peers
def test_the_pdf_has_the_width_and_holds_its_fonts(draw, tmp_path) -> None:
    page = Page.find(85.0)
    _, pdf = write_picture(tmp_path / "flight.svg", draw["flight"](page), page)
    content = pdf.read_bytes()
    [box] = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+) [\d.]+", content)
    assert float(box) == pytest.approx(85 / 25.4 * 72, abs=0.01)
    assert b"/FontFile2" in content or b"/FontFile3" in content, "outlines of the letters used"
