"""The picture of joints in docs/printing.md, cut along the axis. ``UPDATE_DOCS=1`` draws it anew."""

import math

import numpy as np

from driftform.figures.style import INK, MUTED, tint
from driftform.figures.svg import add, path_data, render, start_document
from driftform.types import Module, Morphology

SCALE = 9.0  # px for a millimetre
WIDTH, HEIGHT, HEAD = 460.0, 200.0, 34.0
SPAN = 24.0  # mm on either side of the middle
JOINTS = {
    "A sleeve beside the core: where one side stays wide": ("uuu", "n", {}, 4.0),
    "A rabbet at the equator: where the core fills the hull": ("nnn", "nnn", {}, 0.0),
    "A sleeve with a groove for an O-ring": ("uss", "nnn", {"o_ring": 0.00178}, 4.0),
    "A further cut at a joint of modules, for the bed": ("sssunnnsss", "n", {"bed": (0.2, 0.2, 0.075)}, 59.0),
}


def body(fore, aft):
    from driftform_frusta.builder import FrustaBuilder, FrustaOptions

    tilts = {"u": math.radians(20), "n": -math.radians(20), "s": 0.0}
    sides = [tuple(Module(0.01, tilts[letter]) for letter in side) for side in (fore, aft)]
    return FrustaBuilder(FrustaOptions()).build(Morphology(*sides))


def panel(root, title, left, top):
    from driftform_frusta.colours import colour_of
    from driftform_frusta.kit_options import PartOptions
    from driftform_kit.cutting.pieces import make_kit

    fore, aft, options, middle = JOINTS[title]
    kit = make_kit(body(fore, aft), PartOptions(kit=True, **options))
    axis = top + HEIGHT

    def at(z, r):
        return np.column_stack((left + WIDTH / 2 + (z - middle) * SCALE, axis - r * SCALE))

    clip = np.array([(-SPAN - 1, -1.0), (SPAN + 1, -1.0), (SPAN + 1, 30.0), (-SPAN - 1, 30.0)])
    angle = np.linspace(0, np.pi, 90)
    ball = kit.hull.core * np.column_stack((np.cos(angle), np.sin(angle)))
    if kit.hull.core > middle - SPAN:
        add(root, "path", d=path_data(at(*ball.T), closed=True), fill=tint(MUTED, 0.25))
    for index, piece in enumerate(kit.pieces):
        for ring in _within(piece.rings[0], clip + np.array([middle, 0.0])):
            add(root, "path", d=path_data(at(ring[:, 0], ring[:, 1]), closed=True), fill=colour_of(index))
    add(root, "path", d=f"M{left} {axis:g}H{left + WIDTH:g}", stroke=MUTED, stroke_dasharray="12 3 2 3")
    add(root, "text", title, x=left, y=top - 12, font_size=13, fill=INK)


def _within(ring, window):
    """The part of a ring of (r, z) in a window, as polygons of (z, r)."""
    from manifold3d import CrossSection, FillRule

    section = CrossSection([ring[:, ::-1]], FillRule.NonZero) ^ CrossSection([window], FillRule.NonZero)
    return [np.asarray(polygon) for polygon in section.to_polygons()]


def picture():
    root = start_document(
        2 * WIDTH + 60,
        2 * (HEIGHT + HEAD) + 40,
        "Joints of kits",
        "Sections along the axis: each part has a colour, the core is grey.",
    )
    for index, title in enumerate(JOINTS):
        panel(root, title, 20 + (index % 2) * (WIDTH + 20), 20 + HEAD / 2 + (index // 2) * (HEIGHT + HEAD + 10))
    return render(root)


def test_the_joints_are_as_they_are_made(docs, pages, same_picture):
    same_picture(docs / "images" / "kit-joints.svg", picture())
    assert "(images/kit-joints.svg)" in pages["printing.md"]
