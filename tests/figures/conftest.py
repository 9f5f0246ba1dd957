"""Reading pictures back, and bodies to draw."""

import re
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import strategies as st

from driftform.agent import mass_properties
from driftform.figures.layout import MINUS, text_width
from driftform.types import Agent, Body, Coefficients, Core, End, Trajectory
from driftform.water import Pipe, Scenario, Segment

SVG = "{http://www.w3.org/2000/svg}"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
COMMAND = re.compile(r"([MLAZ])([^MLAZ]*)")


def points_of(element):
    """The points (n, 2) between which an element is drawn, its stroke left out."""

    def get(key):
        return float(element.get(key, "0"))

    match element.tag.removeprefix(SVG):
        case "path":
            ends = [
                [float(v) for v in NUMBER.findall(values)][-2:]
                for letter, values in COMMAND.findall(element.get("d", ""))
                if letter != "Z"
            ]
            return np.array(ends).reshape(-1, 2)
        case "line":
            return np.array([[get("x1"), get("y1")], [get("x2"), get("y2")]])
        case "rect":
            x, y = get("x"), get("y")
            return np.array([[x, y], [x + get("width"), y + get("height")]])
        case "circle":
            centre = np.array([get("cx"), get("cy")])
            return np.array([centre - get("r"), centre + get("r")])
        case "text":
            size = get("font-size")
            width = text_width(element.text or "", size, bold=element.get("font-weight") is not None)
            left = get("x") - width * {"start": 0, "middle": 0.5, "end": 1}[element.get("text-anchor", "start")]
            return np.array([[left, get("y") - 0.8 * size], [left + width, get("y") + 0.25 * size]])
        case _:
            return np.zeros((0, 2))


@dataclass
class Picture:
    """A picture that was read back."""

    root: ET.Element

    @property
    def size(self):
        """Right and lower edge; a figure for a paper begins below its header."""
        left, top, width, height = (float(v) for v in self.root.get("viewBox", "").split())
        assert left == 0 and (top > 0) == self.root.get("font-family", "").startswith("Arial")
        return width, top + height

    @property
    def top(self):
        return float(self.root.get("viewBox", "").split()[1])

    @property
    def texts(self):
        return [e.text or "" for e in self._labels()]

    def _labels(self):
        """The texts, without the halos that lie below them."""
        return [e for e in self.root.iter(SVG + "text") if e.get("class") != "halo"]

    def all(self, class_):
        return [e for e in self.root.iter() if e.get("class") == class_]

    def one(self, class_):
        (element,) = self.all(class_)
        return element

    def outside(self):
        """What is drawn outside the picture."""
        found = []
        for element in self.root.iter():
            points = points_of(element)
            if len(points) and not (
                (points.min(axis=0) >= (-0.01, self.top - 0.01)).all()
                and (points.max(axis=0) <= np.add(self.size, 0.01)).all()
            ):
                found.append(ET.tostring(element, encoding="unicode"))
        return found

    def overlapping_texts(self):
        boxes = [(e.text or "", points_of(e)) for e in self._labels()]
        return [
            (a, b)
            for i, (a, p) in enumerate(boxes)
            for b, q in boxes[:i]
            if (np.minimum(p[1], q[1]) - np.maximum(p[0], q[0]) > 0.5).all()
        ]

    def to_world(self, points):
        """Page to metres, as a reader would do it: along the ticks of the (only) pair of axes."""
        columns = []
        for axis, name in enumerate(("tick-right", "tick-up")):
            values = [float((e.text or "").replace(MINUS, "-")) for e in self.all(name + "-label")]
            places = [points_of(e)[0, axis] for e in self.all(name)]
            slope, shift = np.polyfit(places, values, 1)
            columns.append(shift + slope * points[:, axis])
        return np.column_stack(columns)


ELEMENTS = {"svg", "title", "desc", "rect", "line", "circle", "path", "text"}
ATTRIBUTES = {
    *("width", "height", "viewBox", "role", "aria-hidden", "class", "d", "x", "y", "x1", "y1", "x2", "y2", "cx", "cy"),
    *("r", "rx", "fill", "fill-rule", "fill-opacity", "stroke", "stroke-width", "stroke-linecap", "stroke-linejoin"),
    *("stroke-dasharray", "font-family", "font-size", "font-weight", "font-style", "text-anchor"),
}
"""What cairosvg, Inkscape, librsvg and browsers draw alike; it excludes paint-order, style sheets and patterns."""


@pytest.fixture(scope="session")
def read():
    def read_as_any_reader_does(text):
        root = ET.fromstring(text)
        for element in root.iter():
            assert element.tag.removeprefix(SVG) in ELEMENTS
            assert set(element.keys()) <= ATTRIBUTES, element.keys()
        return Picture(root)

    return read_as_any_reader_does


@pytest.fixture(scope="session")
def points():
    return points_of


def agent_of(aft, fore, radii):
    """An agent with rims of ``radii`` (m) at equal distances from ``-aft`` to ``fore`` (m), and flat ends."""
    x = np.linspace(-aft, fore, len(radii))
    rims = np.column_stack([x, radii])
    wall = 0.00125
    inner = np.column_stack([np.clip(x, x[0] + wall, x[-1] - wall), np.array(radii) - wall])

    def closed(contour):
        return np.vstack([contour[:1] * (1, 0), contour, contour[-1:] * (1, 0)])

    body = Body(closed(rims), closed(inner), x, Core(0.01, 0.05), wall, 1050.0)
    return Agent(body, mass_properties(body), Coefficients(np.zeros((6, 6))))


@pytest.fixture(scope="session")
def make_agent():
    return agent_of


@pytest.fixture(scope="session")
def agents():
    """Bodies from the bare core's size to the longest and the fattest."""
    return st.builds(
        agent_of,
        st.floats(0.0115, 0.2),
        st.floats(0.0115, 0.2),
        st.lists(st.floats(0.0115, 0.145), min_size=2, max_size=41),
    )


@pytest.fixture(scope="session")
def pipe():
    """The pipe with some of its targets."""
    segment = Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0)
    targets = {
        "TP5": (4.5, 0.0, 0.0),
        "TP6": (5.5, 0.0, 0.4),
        "TP7": (5.5, 0.0, -0.4),
        "TP8": (7.0, 0.0, 0.7),
        "TP9": (8.0, 0.0, -0.2),
        "TP10": (8.5, 0.0, 0.1),
    }
    return Scenario(pipe=Pipe(segments=(segment,)), targets=targets)


@pytest.fixture(scope="session")
def fly():
    """Flights that go straight with 1 m/s, from the origin, pitched (positive nose down)."""

    def make(*, rise=0.0, sideways=0.0, pitch=0.0, samples=50):
        t = np.linspace(0.0, 9.0, samples) if samples > 1 else np.zeros(1)
        course = np.array([1.0, sideways, rise])
        c, s = np.cos(pitch), np.sin(pitch)
        # World to body is the transpose of the rotation about y.
        along = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ course
        quaternion = np.tile([np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0], (len(t), 1))
        velocity = np.tile([*along, 0.0, 0.0, 0.0], (len(t), 1))
        return Trajectory(t, t[:, None] * course, quaternion, velocity, End.OUTLET)

    return make
