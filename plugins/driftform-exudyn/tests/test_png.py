"""PNG files, read by Pillow."""

import io

import numpy as np
import pytest
from PIL import Image

from driftform.figures import svg
from driftform.figures.files import ZOOM, rasterise
from driftform_exudyn.encoder import png_bytes


def test_a_png_file_holds_the_pixels():
    pixels = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    image = Image.open(io.BytesIO(png_bytes(pixels)))
    assert (image.format, image.mode, image.size) == ("PNG", "RGB", (5, 7))
    image.load()
    assert (np.asarray(image) == pixels).all()


@pytest.mark.parametrize(("unit", "text"), [("mm", "60mm"), ("px", "226.77")])
def test_a_picture_in_millimetres_becomes_as_many_pixels_as_one_in_px(unit, text):
    root = svg.start_document(60 / 25.4 * 96, 30 / 25.4 * 96, "A box", "A box.", unit=unit)
    drawn = svg.render(root)
    assert f'width="{text}' in drawn
    image = Image.open(io.BytesIO(rasterise(drawn)))
    assert image.size == pytest.approx((ZOOM * 60 / 25.4 * 96, ZOOM * 30 / 25.4 * 96), abs=1)
