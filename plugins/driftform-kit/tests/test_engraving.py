"""Letters, and texts in the wall of a kit's parts."""

import math

import numpy as np
import pytest
from pydantic import ValidationError

from driftform.types import Module, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.csg import Revolve, Text
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.lettering import STROKE, text_length
from driftform_frusta.parts import make_parts
from driftform_frusta.solid import to_manifold
from driftform_kit.cutting.meridian import split_rings
from driftform_kit.cutting.pieces import make_kit

LETTERS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ-._/:+#"


@pytest.fixture(scope="module")
def body():
    """Straight modules on both sides: walls of one radius, 11.45 mm outside."""
    straight = tuple(Module(0.01, 0.0) for _ in range(5))
    return FrustaBuilder(FrustaOptions()).build(Morphology(straight, straight))


def cut_out(piece):
    """The material that a text removes from a part."""
    return to_manifold(Revolve(*split_rings(piece.rings))) ^ to_manifold(piece.engraved.tool)


def engraved(body, text="A-7", **options):
    return PartOptions(kit=True, engrave=text, **options)


@pytest.mark.parametrize("letter", LETTERS)
def test_every_letter_stands_on_the_line_between_its_neighbours(letter):
    solid = to_manifold(Text(letter, 6.0, 2.0))
    x0, y0, z0, x1, y1, z1 = solid.bounding_box()
    half = 6.0 * STROKE / 2
    assert -half - 1e-9 <= x0 and x1 <= 4 + half + 1e-9
    assert -half - 1e-9 <= y0 and y1 <= 6 + half + 1e-9
    assert (z0, z1) == (0.0, 2.0)


def test_no_two_letters_look_alike():
    shapes = {letter: to_manifold(Text(letter, 6.0, 1.0)).slice(0.5) for letter in LETTERS}
    for one, shape in shapes.items():
        for other, second in shapes.items():
            if one < other:
                # Half a square millimetre: what is left of a pen of 0.8 mm that tells a B from an 8.
                differs = (shape - second).area() + (second - shape).area()
                assert differs > 0.5, (one, other)


def test_a_text_is_as_long_as_is_said():
    x0, _, _, x1, _, _ = to_manifold(Text("HELLO", 5.0, 1.0)).bounding_box()
    assert x1 - x0 == pytest.approx(text_length("HELLO", 5.0), abs=1e-6)


def test_a_letter_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="cannot draw 'é'"):
        Text("é", 5.0, 1.0)
    with pytest.raises(ValueError, match="a text needs a letter"):
        Text(" ", 5.0, 1.0)
    with pytest.raises(ValidationError, match="cannot engrave '!é'"):
        PartOptions(engrave="a!é")


@pytest.mark.parametrize("side", ["outside", "inside"])
def test_a_text_takes_its_strokes_times_its_depth_from_the_wall(side, body):
    options = engraved(body, "I-I", engrave_side=side)
    plain = make_parts(body, PartOptions(kit=True))
    parts = make_parts(body, options)
    kit = make_kit(body, options)
    pen = 5.0 * STROKE
    flat = to_manifold(Text("I-I", 5.0, 1.0)).volume()
    for whole, part, piece in zip(plain, parts, kit.pieces, strict=True):
        taken = whole.solid.volume - part.solid.volume
        if piece.engraved is None:
            assert taken == 0
            continue
        # Letters keep their height across the axis, and so cover more of a round wall than of a flat one.
        assert 0.4 * flat * 0.95 < taken < 0.4 * flat * 1.1
        # It is integrated on a grid of 60 points to the height of a letter.
        assert piece.engraved.volume * 1e9 == pytest.approx(taken, rel=2e-3)
        assert len(part.solid.shells) == 1
    assert pen > 0.6
    assert any(piece.engraved for piece in kit.pieces)


@pytest.mark.parametrize("side", ["outside", "inside"])
def test_no_engraving_goes_deeper_than_was_asked_for(side, body):
    options = engraved(body, engrave_side=side, engrave_depth=0.0005)
    kit = make_kit(body, options)
    for piece in kit.pieces:
        if piece.engraved is None:
            continue
        vertices = np.asarray(cut_out(piece).to_mesh64().vert_properties)[:, :3]
        radius = np.hypot(vertices[:, 0], vertices[:, 1])
        facet = 11.45 * (1 - math.cos(math.pi / 64)) + 0.02
        low, high = (10.95, 11.45) if side == "outside" else (10.2, 10.7)
        assert low - facet <= radius.min() and radius.max() <= high + facet


def test_a_text_reads_from_outside_and_not_in_a_mirror(body):
    """An L seen from outside, fore to the right: its stem at its left end, its foot below."""
    kit = make_kit(body, engraved(body, "L"))
    [piece] = [p for p in kit.pieces if p.engraved is not None][:1]
    vertices = np.asarray(cut_out(piece).to_mesh64().vert_properties)[:, :3]
    outward = vertices.mean(axis=0) * (1, 1, 0)
    outward /= np.linalg.norm(outward)
    right = np.array([0.0, 0.0, 1.0])
    up = np.cross(outward, right)
    x, y = vertices @ right, vertices @ up
    stem = x < x.min() + 0.5
    foot = y < y.min() + 0.5
    assert np.ptp(y[stem]) > 4 and np.ptp(x[foot]) > 2.5
    assert np.ptp(x[y > y.max() - 0.5]) < 1


def test_a_text_stays_away_from_the_thin_lip_of_a_rabbet(body):
    options = engraved(body, "AAA", joint="rabbet")
    kit = make_kit(body, options)
    joint = kit.core_joint
    for piece in kit.pieces:
        if piece.engraved is None:
            continue
        low, high = np.array(cut_out(piece).bounding_box())[[2, 5]]
        assert high < min(joint.z, joint.tip) or low > max(joint.z, joint.tip)
