"""Drawing a body of revolution along its axis, with the fore end to the right."""

from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from driftform.agent.distance import radii_at
from driftform.figures import svg
from driftform.figures.projection import simplify_polyline
from driftform.figures.style import tint
from driftform.types import Body, FloatArray


@dataclass(frozen=True)
class Placement:
    """Position of the body frame's origin on the page (px), and the scale (px per metre)."""

    x: float
    y: float
    px_per_m: float

    def to_page(self, points: FloatArray) -> FloatArray:
        """Return page points of (x, z) of the body frame in m, (n, 2)."""
        return np.array([self.x, self.y]) + self.px_per_m * np.asarray(points) * (1.0, -1.0)


def closed_outline(contour: FloatArray) -> FloatArray:
    """Return the meridian on both sides of the axis, as one closed polygon."""
    return np.vstack([contour, contour[::-1] * (1.0, -1.0)])


def draw_shading(parent: ET.Element, body: Body, place: Placement, colour: str, below: float, bands: int = 12) -> None:
    """Fill the outside with bands that are lightest a third of the radius above the axis, like a lit cylinder.

    ``below`` is how far the bands reach below the axis, in radii: 0 stops at the axis, 1 fills the body.
    """
    x, r = simplify_polyline(body.outer, 0.1 / place.px_per_m).T
    for lit in np.linspace(0, 1, bands):
        # The highlight ends above the shaded side, so each band is narrower below the axis than above it.
        top = 1 - 0.62 * lit
        bottom = below if lit == 0 else min(below, 0.78 - 0.78 * lit)
        edge = np.vstack([np.column_stack([x, top * r]), np.column_stack([x, -bottom * r])[::-1]])
        fill = tint(colour, 0.14 + 0.3 * float(1 - lit) ** 1.5)
        svg.add(parent, "path", d=svg.path_data(place.to_page(edge), closed=True), fill=fill)


def inner_joints(body: Body) -> FloatArray:
    """Return x (m) of the joints between modules, without the two ends."""
    # A bare core has a single joint, where modules would start, and no rim there.
    joints = body.joints if len(body.joints) > 1 else body.joints[:0]
    inner: FloatArray = joints[(joints > body.outer[0, 0] + 1e-6) & (joints < body.outer[-1, 0] - 1e-6)]
    return inner


def draw_rims(parent: ET.Element, body: Body, place: Placement, colour: str, width: float, below: float) -> None:
    """Draw the joints between modules as faint lines across the outside."""
    x = inner_joints(body)
    if len(x):
        r = radii_at(body.outer, x)
        rims = place.to_page(np.array([[x, r], [x, -below * r]]).transpose(2, 0, 1))
        svg.add_line(parent, svg.lines_data(rims), colour, width, "joints")
