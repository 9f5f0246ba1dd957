"""The picture of a pipe before any flight."""

from xml.etree import ElementTree as ET

import numpy as np
import pytest

from driftform.figures.pipe import pipe_svg
from driftform.figures.plot import pipe_points
from driftform.water import Scenario

SVG = "{http://www.w3.org/2000/svg}"
PIPE = {
    "radius": 0.1,
    "parts": [
        {"length": 1.0},
        {"kind": "tee", "name": "T", "branch_radius": 0.05, "share": 0.3, "branch": [{"length": 0.4, "outlet": "up"}]},
        {"kind": "bend", "radius": 0.3, "roll_deg": 90},
        {"length": 1.0, "outlet": "on"},
    ],
}
STRAIGHT = {"segments": [{"start": [0, 0, 0], "end": [9, 0, 0], "radius": 1.0}]}


def words_of(text):
    return {element.text for element in ET.fromstring(text).iter(f"{SVG}text")}


def test_a_pipe_that_turns_aside_is_seen_from_the_side_and_from_above():
    words = words_of(pipe_svg(Scenario.model_validate({"pipe": PIPE, "targets": {"out": "on"}}), "A pipe"))
    assert {"A pipe", "Side view", "From above", "release", "out", "up"} <= words
    assert "From above" not in words_of(pipe_svg(Scenario.model_validate({"pipe": STRAIGHT}), "A pipe"))


def test_every_opening_is_drawn_in_each_view():
    root = ET.fromstring(pipe_svg(Scenario.model_validate({"pipe": PIPE}), "A pipe"))
    dashed = [path for path in root.iter(f"{SVG}path") if path.get("stroke-dasharray")]
    assert len(dashed) == 2 * 3
    assert len([path for path in root.iter(f"{SVG}path") if path.get("class") == "water"]) == 2


def test_the_points_of_a_pipe_with_parts_lie_on_its_wall():
    pipe = Scenario.model_validate({"pipe": PIPE}).pipe
    height = pipe.layout.outlets[0].opening.centre[2] + 0.1
    assert np.ptp(pipe_points(pipe)[:, 2]) == pytest.approx(height)
