"""PNG files of pictures without transparency.

Format: W3C, "Portable Network Graphics (PNG) Specification (Third Edition)"; eight bits a channel, no interlacing.
"""

import struct
import zlib

import numpy as np
import numpy.typing as npt

_UP = 2


def png_bytes(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Return a picture, (height, width, 3) of red, green and blue, as a PNG file."""
    height, width, _ = pixels.shape
    rows = np.empty((height, 1 + 3 * width), dtype=np.uint8)
    # Each row is stored as its difference from the row above, which compresses far better.
    rows[:, 0] = _UP
    flat = pixels.reshape(height, -1)
    rows[0, 1:] = flat[0]
    rows[1:, 1:] = flat[1:] - flat[:-1]
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = b"IHDR" + header, b"IDAT" + zlib.compress(rows.tobytes(), 6), b"IEND"
    chunks = (struct.pack(">I", len(part) - 4) + part + struct.pack(">I", zlib.crc32(part)) for part in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
