"""The contract of renderers is of use only if it refuses renderers that are wrong: each of these has one fault."""

import itertools
from contextlib import nullcontext

import numpy as np
import pytest

from driftform.interfaces import Renderer, Table
from driftform.motion.path.interpolation import even_times, interpolate_attitudes
from driftform.testing import RendererContract
from driftform.types import WrittenFile
from driftform.util.files import write_whole
from driftform.util.rotations import matrix_from_quaternion
from driftform_exudyn.encoder import encode, png_bytes

pytestmark = pytest.mark.peers

TICKS = itertools.count()


class Sketch(Renderer):
    """A square that goes right, and is as bright as the nose is high."""

    name = "sketch"
    suffixes = (".mp4", ".gif")
    stills = (".png",)
    rate = 10.0
    columns = 80

    def film(self, agent, flight, scenario, path, progress):
        self.check(path)
        t = even_times(float(flight.t[-1]), 1 / self.rate)

        def images():
            for done, when in enumerate(t, start=1):
                yield self.image(flight, when)
                progress(done, len(t))

        write_whole(path, lambda part: encode(images(), part, path.suffix, 10.0))
        return WrittenFile(self.name, str(path))

    def still(self, agent, flight, scenario, path, at):
        self.check_still(path)
        image = self.image(flight, at)
        write_whole(path, lambda part: part.write_bytes(png_bytes(image)))
        return WrittenFile(self.name, str(path))

    def image(self, flight, when):
        image = np.full((64, self.columns, 3), 255, np.uint8)
        nose = matrix_from_quaternion(interpolate_attitudes(flight, np.array([when])))[0, 2, 0]
        left = 16 * int(10 * when)
        image[16:48, left : left + 16] = int(100 + 100 * nose)
        return image


def level(sketch, flight, when):
    object.__setattr__(flight, "quaternion", np.tile([1.0, 0, 0, 0], (len(flight.t), 1)))
    return Sketch.image(sketch, flight, when)


FORMATS, STILL = (
    "test_each_format_gives_a_film_where_it_was_asked_for",
    "test_a_still_shows_the_moment_that_was_asked_for",
)
FROZEN = {"image": lambda sketch, flight, when: Sketch.image(sketch, flight, 0.0)}
CHANGING = {"image": lambda sketch, flight, when: Sketch.image(sketch, flight, when) - np.uint8(next(TICKS) % 50)}


@pytest.mark.parametrize(
    ("fault", "test"),
    [
        ({"columns": 64}, FORMATS),
        ({"rate": 20.0}, FORMATS),
        (FROZEN, "test_motion_and_attitude_are_visible"),
        (FROZEN, STILL),
        ({"image": level}, "test_motion_and_attitude_are_visible"),
        (CHANGING, "test_the_same_flight_gives_the_same_frames"),
        (dict.fromkeys(("check", "check_still"), lambda sketch, path: None), "test_an_unknown_suffix_is_refused"),
    ],
)
def test_a_faulty_renderer_is_refused(fault, test, tmp_path):
    arguments = {"name": "film.mkw"} if "suffix" in test else {}
    for members, folder in (({}, tmp_path / "sound"), (fault, tmp_path / "faulty")):
        folder.mkdir()
        kind = type("Mine", (Sketch,), members)
        values = {"rate": 10.0, "size": (80, 64), "plugin": lambda self, kind=kind: kind(Table())}
        contract = type("Contract", (RendererContract,), {**values, "copy": values["plugin"]})()
        with pytest.raises((AssertionError, pytest.fail.Exception)) if members else nullcontext():
            getattr(contract, test)(tmp_path=folder, **arguments)
