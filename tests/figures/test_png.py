"""PNG files, read by Pillow."""

import io

import numpy as np
from PIL import Image

from driftform.figures.png import png_bytes


def test_a_png_file_holds_the_pixels():
    pixels = np.random.default_rng(1).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    image = Image.open(io.BytesIO(png_bytes(pixels)))
    assert (image.format, image.mode, image.size) == ("PNG", "RGB", (5, 7))
    image.load()
    assert (np.asarray(image) == pixels).all()
