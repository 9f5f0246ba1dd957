"""The hull of an agent for display: modules in two shades, the fore end in another colour."""

from collections.abc import Iterable

import numpy as np

from driftform.figures import style
from driftform.types import Body, FloatArray
from driftform_exudyn.shapes import FULL_TURN, Shape, revolve

NOSE_SHARE = 0.1
"""Share of the length that has the colour of the fore end."""


def make_hull(body: Body, scale: float = 1.0) -> Shape:
    """Return the outer surface in the body frame, magnified about the core."""
    nose = float(body.outer[-1, 0]) - NOSE_SHARE * body.length
    contour = _split_contour(body.outer, [nose, *body.joints])
    middle = (contour[:-1, 0] + contour[1:, 0]) / 2
    shades = (style.ORANGE, style.tint(style.ORANGE, 0.6))
    module = np.searchsorted(body.joints, middle)
    colours = [style.BLUE if x > nose else shades[m % 2] for x, m in zip(middle, module, strict=True)]
    return revolve(scale * contour, np.eye(3), FULL_TURN, colours)


def _split_contour(contour: FloatArray, cuts: Iterable[float]) -> FloatArray:
    """Return the contour with a point wherever it crosses one of the ``cuts`` (x, m), without edges of zero length."""
    for x in cuts:
        (crossing,) = np.nonzero((contour[:-1, 0] - x) * (contour[1:, 0] - x) < 0)
        p, q = contour[crossing], contour[crossing + 1]
        between = p + ((x - p[:, 0]) / (q[:, 0] - p[:, 0]))[:, None] * (q - p)
        contour = np.insert(contour, crossing + 1, between, axis=0)
    lengths = np.linalg.norm(np.diff(contour, axis=0), axis=1)
    return np.asarray(contour[np.append(True, lengths > 1e-9)], dtype=np.float64)
