"""Films against flights, factors with intervals, and drops: what the pictures show, and where."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from driftform.testing.bodies import cylinder_body
from driftform_calibration.figures import TrackPanel, drop_svg, ruler_svg, tracks_svg

SVG = "{http://www.w3.org/2000/svg}"


def panel(flat=True):
    t = np.linspace(0, 1, 30)
    path = np.column_stack([0.1 * t, -0.5 * t**2])
    seen = path + 0.002 * np.sin(40 * t)[:, None]
    if not flat:
        seen = np.column_stack([np.full(30, np.nan), seen[:, 1]])
    return TrackPanel("drop-1.csv", t, seen, t, 1.1 * path, path, np.full(30, 0.02), np.full(30, 0.002))


def find(svg, tag, name):
    return [e for e in ET.fromstring(svg).iter(f"{SVG}{tag}") if e.get("class") == name]


@pytest.mark.parametrize("flat", [True, False])
def test_every_point_and_both_flights_are_drawn(flat):
    svg = tracks_svg([panel(flat), panel(flat)], "films", "20 mm before, 2 mm after")
    assert len(find(svg, "circle", "seen")) == 60
    assert len(find(svg, "path", "before")) == len(find(svg, "path", "after")) == 2
    assert len(find(svg, "path", "distance")) == 4


def test_a_ruler_is_as_long_as_it_says():
    root = ET.fromstring(ruler_svg(100))
    assert re.fullmatch(r"[\d.]+mm", root.get("width"))
    width = float(root.get("width").removesuffix("mm"))
    per_mm = float(root.get("viewBox").split()[2]) / width
    ticks = [float(line.get("x1")) for line in root.iter(f"{SVG}line")]
    assert (max(ticks) - min(ticks)) / per_mm == pytest.approx(100, abs=0.1)


def test_a_drop_starts_below_the_surface_of_its_tank():
    path = np.array([[0.0, -0.05], [0.02, -0.2], [0.03, -0.38]])
    level = np.array([1.0, 0, 0, 0])
    svg = drop_svg("Drop 1", "pitch +0 deg", cylinder_body(0.1, 0.02), level, path, (0.6, 0.4))
    [water] = find(svg, "rect", "water")
    top, height = float(water.get("y")), float(water.get("height"))
    [line] = find(svg, "path", "path")
    ys = [float(pair.split()[1]) for pair in re.findall(r"[-\d.]+ [-\d.]+", line.get("d"))]
    assert ys[0] == pytest.approx(top + height * 0.05 / 0.4, abs=0.5)
    assert ys[-1] == pytest.approx(top + height * 0.38 / 0.4, abs=0.5)
