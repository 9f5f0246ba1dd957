"""Pictures of parts on the bed."""

import struct
import zlib

import numpy as np
import pytest

from driftform.figures.png import png_bytes
from driftform_frusta.csg import Box, Translate
from driftform_frusta.mesh import mesh_of
from driftform_frusta.picture import Shape, draw
from driftform_frusta.solid import to_solid

RED, BLUE = "#ff0000", "#0000ff"
BED = (100.0, 100.0)


def shape(size, at, colour):
    corner = tuple(a - s / 2 for a, s in zip(at[:2], size[:2], strict=True))
    mesh = mesh_of(to_solid(Translate((*corner, at[2]), Box(size))))
    return Shape(mesh.vertices.astype(float), mesh.triangles, colour)


def is_of(picture, channel):
    """Pixels where one channel is far above the others."""
    others = [c for c in range(3) if c != channel]
    return picture[..., channel].astype(int) - picture[..., others].max(axis=-1) > 60


def decoded(png):
    """Pixels of a PNG file by the letter of its specification."""
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    at, packed, size = 8, b"", (0, 0)
    while at < len(png):
        (length,) = struct.unpack(">I", png[at : at + 4])
        kind, data = png[at + 4 : at + 8], png[at + 8 : at + 8 + length]
        assert struct.unpack(">I", png[at + 8 + length : at + 12 + length])[0] == zlib.crc32(kind + data)
        if kind == b"IHDR":
            size = struct.unpack(">II", data[:8])
            assert tuple(data[8:]) == (8, 2, 0, 0, 0)
        packed += data if kind == b"IDAT" else b""
        at += 12 + length
    width, height = size
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    assert (rows[:, 0] == 2).all()
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(height, width, 3)


def test_a_png_file_holds_the_pixels():
    pixels = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    assert (decoded(png_bytes(pixels)) == pixels).all()


def test_a_picture_has_the_size_that_was_asked_for_and_shows_the_part_in_its_colour():
    picture = draw([shape((20, 20, 40), (0, 0, 0), RED)], BED, 120, 90)
    assert picture.shape == (90, 120, 3)
    red = is_of(picture, 0)
    assert 0.05 < red.mean() < 0.9
    assert not red[0].any() and not red[-1].any() and not red[:, 0].any() and not red[:, -1].any()


def test_what_is_nearer_hides_what_is_behind_it_whatever_the_order():
    # The eye is in front, where y is less.
    near, far = shape((60, 4, 60), (0, -30, 0), RED), shape((20, 4, 20), (0, -15, 0), BLUE)
    for shapes in ([near, far], [far, near]):
        picture = draw(shapes, BED, 160, 120)
        assert is_of(picture, 0).any()
        assert not is_of(picture, 2).any()


def test_a_part_stands_upright_on_the_page():
    picture = draw([shape((10, 10, 20), (0, 0, 0), RED), shape((10, 10, 20), (0, 0, 20), BLUE)], BED, 90, 120)
    rows = [np.flatnonzero(is_of(picture, channel).any(axis=1)).mean() for channel in (0, 2)]
    assert rows[1] < rows[0]


def test_to_the_right_on_the_bed_is_to_the_right_on_the_page():
    picture = draw([shape((10, 10, 20), (-20, 0, 0), RED), shape((10, 10, 20), (20, 0, 0), BLUE)], BED)
    columns = [np.flatnonzero(is_of(picture, channel).any(axis=0)).mean() for channel in (0, 2)]
    assert columns[0] < columns[1]


def test_the_area_of_a_face_is_that_of_its_projection():
    """A slab seen from above and from the front: its top and front side by the sines of the eye's elevation."""
    picture = draw([shape((60, 60, 1e-3), (0, 0, 0), RED)], (1000.0, 1000.0), 400, 300)
    red = is_of(picture, 0)
    wide, high = (np.ptp(np.flatnonzero(red.any(axis=axis))) + 1 for axis in (0, 1))
    # A square turned by the azimuth a: its width is cos a + sin a sides, and its height that times sin(24 deg).
    assert high / wide == pytest.approx(np.sin(np.deg2rad(24.0)), rel=0.05)
    turn = np.deg2rad(62.0)
    side = wide / (np.cos(turn) + np.sin(turn))
    assert red.sum() == pytest.approx(side**2 * np.sin(np.deg2rad(24.0)), rel=0.05)


def test_a_part_casts_a_shadow_on_the_bed():
    high, flat = (draw([shape((20, 20, h), (0, 0, 0), RED)], BED) for h in (60, 0.01))

    def darkest(picture):
        free = ~is_of(picture, 0)
        return picture[free].mean(axis=-1).min()

    assert darkest(high) < darkest(flat) - 10
