"""Images -> a film, by the ffmpeg of imageio-ffmpeg, or a PNG file.

PNG: W3C, "Portable Network Graphics (PNG) Specification (Third Edition)"; eight bits a channel, no interlacing.
"""

import contextlib
import struct
import subprocess
import tempfile
import zlib
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from driftform.errors import WorkFailedError

if TYPE_CHECKING:
    from driftform_exudyn.stage import Image

SUFFIXES = (".mp4", ".gif")
"""Suffixes of the formats."""

# The colours are those of HD video; the index is written first, so that a film plays while it loads.
_MP4 = (
    *("-vf", "scale=out_color_matrix=bt709", "-pix_fmt", "yuv420p", "-c:v", "libx264", "-crf", "18"),
    *("-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"),
    *("-movflags", "+faststart", "-f", "mp4"),
)
# A palette for each frame: for one of all frames, ffmpeg would keep the whole film in memory.
_GIF = (
    *("-lavfi", "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=bayer:bayer_scale=4"),
    *("-loop", "0", "-f", "gif"),
)


def find_ffmpeg() -> str:
    """Return the path of ffmpeg. Raises WorkFailedError if it is not installed."""
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise WorkFailedError(
            'a film needs ffmpeg, which is not installed; run: uv sync --extra film, or pip install "driftform[film]"'
        ) from None


def encode(images: "Iterable[Image]", path: Path, suffix: str, fps: float) -> None:
    """Write images of one size as a film in the format of ``suffix``.

    Raises WorkFailedError if ffmpeg fails; the message ends with its error message.
    """
    # Without "file:" ffmpeg reads the text before a colon as a protocol.
    arguments = (*(_MP4 if suffix == ".mp4" else _GIF), "-fflags", "+bitexact", f"file:{path}")
    images = iter(images)
    first = next(images)
    height, width, _ = first.shape
    raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{fps:g}", "-i", "-")
    command = [find_ffmpeg(), "-y", "-v", "error", *raw, *arguments]
    with tempfile.TemporaryFile() as said:
        with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=said) as process:
            assert process.stdin is not None
            try:
                # If ffmpeg stops early, it reports the reason itself.
                with contextlib.suppress(BrokenPipeError), process.stdin:
                    for image in chain([first], images):
                        process.stdin.write(image.tobytes())
                process.wait()
            except BaseException:
                process.kill()
                raise
        if process.returncode:
            said.seek(0)
            lines = said.read().decode(errors="replace").split("\n")
            raise WorkFailedError(f"ffmpeg failed: {next(filter(None, reversed(lines)), 'it gives no reason')}")


def png_bytes(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Return a picture, (height, width, 3) of red, green and blue, as a PNG file."""
    height, width, _ = pixels.shape
    rows = np.empty((height, 1 + 3 * width), dtype=np.uint8)
    # The filter 2 stores each row as its difference from the row above, which compresses far better.
    rows[:, 0] = 2
    flat = pixels.reshape(height, -1)
    rows[0, 1:] = flat[0]
    rows[1:, 1:] = flat[1:] - flat[:-1]
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = b"IHDR" + header, b"IDAT" + zlib.compress(rows.tobytes(), 6), b"IEND"
    chunks = (struct.pack(">I", len(part) - 4) + part + struct.pack(">I", zlib.crc32(part)) for part in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
