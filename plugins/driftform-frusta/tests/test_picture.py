"""Pictures of parts on the bed, and the pixels of a drawing."""

import io

import numpy as np
import pytest
from manifold3d import Manifold
from PIL import Image

from driftform.figures import svg
from driftform.figures.files import ZOOM, rasterise
from driftform_frusta.picture import plate_svg
from driftform_frusta.solid import Solid, make_mesh

RED, BLUE = "#ff0000", "#0000ff"
BED = 100.0


def mesh_of(solid):
    return make_mesh(Solid.from_manifold(solid))


def shape(size, at, colour):
    corner = tuple(a - s / 2 for a, s in zip(at[:2], size[:2], strict=True))
    return mesh_of(Manifold.cube(size).translate((*corner, at[2]))), colour


def is_of(picture, channel):
    """Pixels where one channel is far above the others."""
    others = [c for c in range(3) if c != channel]
    return picture[..., channel].astype(int) - picture[..., others].max(axis=-1) > 60


def draw(shapes, bed, width=400, height=300):
    """Pixels of a picture, (height, width, 3)."""
    png = rasterise(plate_svg(shapes, bed, width / ZOOM, height / ZOOM))
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


def test_a_picture_has_the_size_that_was_asked_for_and_shows_the_part_in_its_colour():
    picture = draw([shape((20, 20, 40), (0, 0, 0), RED)], BED, 120, 90)
    assert picture.shape == (90, 120, 3)
    red = is_of(picture, 0)
    wide, high = (np.ptp(np.flatnonzero(red.any(axis=axis))) + 1 for axis in (0, 1))
    assert high / wide == pytest.approx(2, rel=0.05) and 70 < high < 80
    assert not red[0].any() and not red[-1].any() and not red[:, 0].any() and not red[:, -1].any()


def test_what_is_nearer_hides_what_is_behind_it_whatever_the_order():
    # The eye is in front, where y is less.
    near, far = shape((60, 4, 60), (0, -30, 0), RED), shape((20, 4, 20), (0, 15, 0), BLUE)
    for shapes in ([near, far], [far, near]):
        picture = draw(shapes, BED, 160, 120)
        assert is_of(picture, 0).any()
        assert not is_of(picture, 2).any()


@pytest.mark.parametrize(("places", "axis"), [(((0, 0, 20), (0, 0, 0)), 1), (((-20, 0, 0), (20, 0, 0)), 0)])
def test_up_and_to_the_right_on_the_bed_are_so_on_the_page(places, axis):
    picture = draw(
        [shape((10, 10, 20), at, colour) for at, colour in zip(places, (RED, BLUE), strict=True)], BED, 90, 120
    )
    first, second = (np.flatnonzero(is_of(picture, channel).any(axis=axis)).mean() for channel in (0, 2))
    assert first < second


@pytest.mark.parametrize(("unit", "text"), [("mm", "60mm"), ("px", "226.77")])
def test_a_drawing_in_millimetres_becomes_as_many_pixels_as_one_in_px(unit, text):
    drawn = svg.render(svg.start_document(60 / 25.4 * 96, 30 / 25.4 * 96, "A box", "A box.", unit=unit))
    assert f'width="{text}' in drawn
    image = Image.open(io.BytesIO(rasterise(drawn)))
    assert image.size == pytest.approx((ZOOM * 60 / 25.4 * 96, ZOOM * 30 / 25.4 * 96), abs=1)
