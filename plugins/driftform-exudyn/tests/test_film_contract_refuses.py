"""The contract of renderers is of use only if it refuses renderers that are wrong: each of these has one fault."""

import itertools
from pathlib import Path

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

        self.write(path, lambda part: encode(images(), part, path.suffix, 10.0))
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

    def write(self, path, encoded):
        write_whole(path, encoded)


class Narrow(Sketch):
    columns = 64


class Slow(Sketch):
    rate = 20.0


class Frozen(Sketch):
    def image(self, flight, when):
        return super().image(flight, 0.0)


class WithoutAttitude(Sketch):
    def image(self, flight, when):
        level = np.tile([1.0, 0, 0, 0], (len(flight.t), 1))
        object.__setattr__(flight, "quaternion", level)
        return super().image(flight, when)


class Changing(Sketch):
    def image(self, flight, when):
        return super().image(flight, when) - np.uint8(next(TICKS) % 50)


class Careless(Sketch):
    def write(self, path: Path, encoded):
        path.write_bytes(b"to be filled")
        encoded(path)


class Silent(Sketch):
    def film(self, agent, flight, scenario, path, progress):
        return super().film(agent, flight, scenario, path, lambda done, total: progress(total, total))


class Undemanding(Sketch):
    def check(self, path):
        pass

    def check_still(self, path):
        pass


class Astray(Sketch):
    def still(self, agent, flight, scenario, path, at):
        return super().still(agent, flight, scenario, path.with_stem("elsewhere"), at)


class Demanding(Sketch):
    def still(self, agent, flight, scenario, path, at):
        assert len(flight.t) > 1
        return super().still(agent, flight, scenario, path, at)


FAULTS: dict[type[Sketch], tuple[str, ...]] = {
    Narrow: (
        "test_each_format_gives_a_film_where_it_was_asked_for",
        "test_a_still_shows_the_moment_that_was_asked_for",
    ),
    Slow: ("test_each_format_gives_a_film_where_it_was_asked_for",),
    Frozen: ("test_motion_and_attitude_are_visible", "test_a_still_shows_the_moment_that_was_asked_for"),
    WithoutAttitude: ("test_motion_and_attitude_are_visible",),
    Changing: ("test_the_same_flight_gives_the_same_frames", "test_a_still_shows_the_moment_that_was_asked_for"),
    Careless: ("test_an_interrupted_film_leaves_nothing_behind_and_keeps_an_older_one",),
    Silent: ("test_progress_is_reported_frame_by_frame",),
    Undemanding: ("test_an_unknown_suffix_is_refused",),
    Astray: ("test_a_still_shows_the_moment_that_was_asked_for",),
    Demanding: ("test_a_flight_of_one_sample_and_open_water_are_shown_too",),
}
CASES = [(fault, test) for fault, tests in FAULTS.items() for test in tests]


def contract_of(kind: type[Sketch]) -> RendererContract:
    class Contract(RendererContract):
        rate, size = 10.0, (80, 64)

        def plugin(self) -> Sketch:
            return kind(Table())

    return Contract()


@pytest.mark.parametrize(("fault", "test"), CASES, ids=[f"{f.__name__}-{t}" for f, t in CASES])
def test_a_faulty_renderer_is_refused(fault, test, tmp_path):
    arguments = {"name": "film.mkw"} if "suffix" in test else {}
    for kind, folder in ((Sketch, tmp_path / "sound"), (fault, tmp_path / "faulty")):
        folder.mkdir()
        check = getattr(contract_of(kind), test)
        if kind is Sketch:
            check(tmp_path=folder, **arguments)
        else:
            with pytest.raises((AssertionError, pytest.fail.Exception)):
                check(tmp_path=folder, **arguments)
