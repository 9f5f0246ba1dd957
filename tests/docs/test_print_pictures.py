"""The pictures of docs/printing.md: five agents as drawings, and their kits on the bed. ``UPDATE_DOCS=1`` draws them anew."""

import io
import os

import numpy as np
import pytest
from PIL import Image

from driftform.figures.section import section_svg
from driftform.interfaces import ExportJob
from driftform.study import load_study

BOTH_SIDES = "addF-tiltp-2-L-moveF-addF-tiltn-1-L-moveF-addB-tiltn-2-L-moveB-addB-tiltn-2-L-moveB-addB-tiltp-2-L-moveN"

# How each is made: a word, or the genome of that number among random ones, and the settings of its study.
AGENTS = {
    "both-sides": (BOTH_SIDES, ()),
    "float": (1, ()),
    "sinker": (0, ()),
    "one-sided": (56, ("grammar.occupied=skip",)),
    "bell": (31, ("grammar.occupied=skip", "grammar.tilt_reference=neighbour")),
}


def job(name):
    source, settings = AGENTS[name]
    study = load_study("paper", settings=settings, run={"seed": 0})
    pipeline, rng = study.make_pipeline(), np.random.default_rng(3)
    if isinstance(source, str):
        genome = pipeline.grammar.parse(source)
    else:
        genome = [pipeline.grammar.random(rng) for _ in range(source + 1)][source]
    return ExportJob(name, pipeline.make_agent(genome), pipeline.scenario, {}, f"r1:{name}")


def plate(name):
    from driftform_frusta.exporters.threemf import ThreeMfExporter
    from driftform_frusta.kit_options import PartOptions
    from driftform_frusta.parts import make_parts, settle_ballast

    body, exporter = job(name).agent.body, ThreeMfExporter(PartOptions(kit=True))
    placed = exporter.place_parts(make_parts(body, settle_ballast(body, exporter.options)))
    return exporter.draw_plate([part for part in placed if part.plate == 0], 200.0, 150.0)


def pixels(png):
    """A picture as numbers, (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=np.float64)


@pytest.mark.parametrize("name", AGENTS)
def test_drawings_are_up_to_date(docs, name, same_picture):
    shown, title = job(name), name.replace("-", " ").capitalize()
    same_picture(docs / "images" / f"section-{name}.svg", section_svg(shown.agent, title, shown.scenario))


def test_the_assembly_sheet_is_up_to_date(docs, same_picture):
    from driftform_frusta.kit_options import PartOptions
    from driftform_kit.sheet.contents import plan_sheet
    from driftform_kit.sheet.drawing import draw_pages

    pages = draw_pages(plan_sheet(job("float"), PartOptions(kit=True)))
    for number, page in enumerate(pages, 1):
        same_picture(docs / "images" / f"assembly-sheet-{number}.svg", page)


@pytest.mark.parametrize("name", AGENTS)
def test_plates_are_up_to_date(docs, name):
    path, drawn = docs / "images" / f"plate-{name}.png", plate(name)
    if os.environ.get("UPDATE_DOCS") == "1":
        path.write_bytes(drawn)
    assert np.abs(pixels(path.read_bytes()) - pixels(drawn)).mean() < 0.5


def test_the_page_shows_each_of_them(pages):
    for name in AGENTS:
        assert f"(images/section-{name}.svg)" in pages["printing.md"]
        assert f"(images/plate-{name}.png)" in pages["printing.md"]
