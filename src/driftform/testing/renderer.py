"""Contract of renderers."""

import subprocess
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import pytest

from driftform.agent import mass_properties
from driftform.errors import InputError
from driftform.interfaces import Renderer
from driftform.plugins.seams import require_file
from driftform.testing.agents import first_sample, straight_pipe
from driftform.testing.bodies import hollow_body
from driftform.testing.contract import SeamContract
from driftform.types import Agent, Coefficients, End, Trajectory, WrittenFile
from driftform.water import Scenario

Frames: TypeAlias = npt.NDArray[np.uint8]
"""Frames of a film, (frames, height, width, 3): red, green and blue."""


def read_film(path: Path) -> Frames:
    """Return the frames of a film, read by the ffmpeg of the package imageio-ffmpeg."""
    from imageio_ffmpeg import get_ffmpeg_exe

    # Read a sequence of PPM images, because each begins with its size.
    command = [get_ffmpeg_exe(), "-v", "error", "-i", path, "-fps_mode", "passthrough"]
    done = subprocess.run([*command, "-f", "image2pipe", "-c:v", "ppm", "-"], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    magic, size, depth, _ = done.stdout.split(b"\n", 3)
    assert (magic, depth) == (b"P6", b"255")
    width, height = map(int, size.split())
    head = len(b"\n".join([magic, size, depth, b""]))
    frames = np.frombuffer(done.stdout, np.uint8).reshape(-1, head + 3 * width * height)
    return frames[:, head:].reshape(-1, height, width, 3)


def drifting_trajectory(seconds: float = 0.4, turn: float = 1.0) -> Trajectory:
    """Return a trajectory along x at 1 m/s from the origin, during which the pitch grows by ``turn`` (rad)."""
    t = np.linspace(0, seconds, 21)
    half = turn * t / seconds / 2
    zero = 0 * t
    position = np.column_stack([t, zero, zero])
    quaternion = np.column_stack([np.cos(half), zero, np.sin(half), zero])
    ahead, up = np.cos(2 * half), np.sin(2 * half)
    velocity = np.column_stack([ahead, zero, up, zero, zero + turn / seconds, zero])
    return Trajectory(t, position, quaternion, velocity, End.HORIZON)


class RendererContract(SeamContract[Renderer[Any]]):
    """Inherit this class, make the renderer, and set the rate and the size of its films::

        class TestMyRenderer(RendererContract):
            rate, size = 10.0, (160, 90)

            def plugin(self) -> MyRenderer:
                return MyRenderer(MyOptions(fps=10, width=160, height=90))

    A small and coarse film keeps the tests quick.

    Attributes:
        rate: frames per second of the flight.
        size: width and height of a frame, px.
    """

    rate: float = 25.0
    size: tuple[int, int] = (640, 360)

    def read(self, path: Path) -> Frames:
        """Return the frames of a film; override it for formats that ffmpeg does not read."""
        return read_film(path)

    def agent(self) -> Agent:
        """Return the agent of the film: a capped hollow tube, without a genome."""
        body = hollow_body()
        return Agent(body, mass_properties(body), Coefficients(0.01 * np.eye(6)))

    def scenario(self) -> Scenario:
        """Return the scenario of the film: half a metre of pipe, with a target."""
        return Scenario(pipe=straight_pipe(0.5, 0.1), targets={"leak": (0.3, 0.0, 0.05)})

    def film(
        self, path: Path, renderer: Renderer[Any] | None = None, progress: Any = lambda done, total: None, **flight: Any
    ) -> WrittenFile:
        """Make a film of a ``trajectory``, by default of one that drifts and pitches, in the ``scenario``."""
        renderer = renderer or self.plugin()
        return require_file(renderer.film(*self._flight(**flight), path, progress), renderer, "film")

    def still(self, path: Path, at: float = 0.2, **flight: Any) -> WrittenFile:
        """Make a still of a trajectory, by default of the same one."""
        renderer = self.plugin()
        return require_file(renderer.still(*self._flight(**flight), path, at), renderer, "still")

    def _flight(
        self, trajectory: Trajectory | None = None, scenario: Scenario | None = None
    ) -> tuple[Agent, Trajectory, Scenario]:
        return self.agent(), trajectory or drifting_trajectory(), scenario or self.scenario()

    def frames(self, folder: Path, **flight: Any) -> npt.NDArray[np.int_]:
        """Make a film in the first of the formats; return its frames, whose differences may be negative."""
        path = folder / f"film{self.plugin().suffixes[0]}"
        self.film(path, **flight)
        return self.read(path).astype(int)

    def test_a_film_is_where_it_was_asked_for_in_every_format(self, tmp_path: Path) -> None:
        """Each suffix gives a film that can be read, and no other file is written; no part of an older film remains."""
        renderer = self.plugin()
        assert renderer.suffixes
        for suffix in renderer.suffixes:
            path = tmp_path / suffix / f"film{suffix}"
            renderer.check(path)
            written = self.film(path)
            assert Path(written.path) == path and written.format == renderer.name
            assert list(path.parent.iterdir()) == [path]
            path.write_bytes(b"old " * 1_000_000)
            self.film(path)
            assert path.stat().st_size < 4_000_000
            assert len(self.read(path)) > 1

    def test_it_has_the_frames_and_the_size_that_were_asked_for(self, tmp_path: Path) -> None:
        """The number of frames is duration times rate, within one frame for the ends."""
        frames = self.frames(tmp_path)
        assert abs(len(frames) - self.rate * drifting_trajectory().t[-1]) <= 1
        assert frames.shape[1:] == (self.size[1], self.size[0], 3)

    def test_frames_differ_while_the_agent_moves(self, tmp_path: Path) -> None:
        """Between consecutive frames some pixels change clearly."""
        change = np.abs(np.diff(self.frames(tmp_path), axis=0)).max(axis=(1, 2, 3))
        assert (change > 32).all()

    def test_the_attitude_is_visible(self, tmp_path: Path) -> None:
        """The last frame of a flight that turns by a right angle differs from that of a flight that does not turn."""
        straight, turned = (
            self.frames(tmp_path, trajectory=drifting_trajectory(turn=turn))[-1] for turn in (0.0, np.pi / 2)
        )
        assert np.abs(straight - turned).max() > 64

    def test_the_same_flight_gives_the_same_frames(self, tmp_path: Path) -> None:
        """A renderer that was sent to another process makes the same frames."""
        np.testing.assert_array_equal(self.frames(tmp_path), self.frames(tmp_path, renderer=self.copy()))

    def test_a_flight_of_one_sample_and_open_water_are_filmed_too(self, tmp_path: Path) -> None:
        """A flight that ended at its release has one sample, and a scenario needs neither pipe nor targets."""
        assert len(self.frames(tmp_path, trajectory=first_sample(drifting_trajectory()))) >= 1
        assert len(self.frames(tmp_path, scenario=Scenario())) > 1

    def test_progress_is_reported_frame_by_frame(self, tmp_path: Path) -> None:
        """Each call reports one more frame than the call before, up to the number of frames."""
        reported: list[tuple[int, int]] = []
        count = len(self.frames(tmp_path, progress=lambda done, total: reported.append((done, total))))
        assert reported == [(done, count) for done in range(1, count + 1)]

    @pytest.mark.parametrize("name", ["film.mkw", "film", "film.", ".mp4"])
    def test_an_unknown_suffix_is_refused(self, name: str, tmp_path: Path) -> None:
        """``check`` refuses it before the flight, and so does ``film``; nothing is written."""
        with pytest.raises(InputError, match=self.plugin().suffixes[0]):
            self.plugin().check(tmp_path / name)
        with pytest.raises(InputError):
            self.film(tmp_path / name)
        assert list(tmp_path.iterdir()) == []

    def test_an_interrupted_film_leaves_nothing_behind_and_keeps_an_older_one(self, tmp_path: Path) -> None:
        """This holds for every format, also if the interruption is at the last frame."""

        def interrupt(done: int, total: int) -> None:
            if done == total:
                raise KeyboardInterrupt

        for suffix in self.plugin().suffixes:
            path = tmp_path / suffix / f"film{suffix}"
            path.parent.mkdir()
            with pytest.raises(KeyboardInterrupt):
                self.film(path, progress=interrupt)
            assert list(path.parent.iterdir()) == []
            path.write_bytes(b"old")
            with pytest.raises(KeyboardInterrupt):
                self.film(path, progress=interrupt)
            assert list(path.parent.iterdir()) == [path] and path.read_bytes() == b"old"

    def test_a_still_is_one_picture_where_it_was_asked_for(self, tmp_path: Path) -> None:
        """Each of ``stills`` gives a picture of the size of a film, and replaces an older one."""
        renderer = self.plugin()
        for suffix in renderer.stills:
            path = tmp_path / suffix / f"still{suffix}"
            path.parent.mkdir()
            path.write_bytes(b"old " * 1_000_000)
            renderer.check_still(path)
            written = self.still(path)
            assert Path(written.path) == path and written.format == renderer.name
            assert list(path.parent.iterdir()) == [path]
            assert self.read(path).shape == (1, self.size[1], self.size[0], 3)

    def test_a_still_shows_the_moment_that_was_asked_for(self, tmp_path: Path) -> None:
        """Release and end give different pictures, and the same moment always gives the same picture."""
        for suffix in self.plugin().stills:
            images = []
            for at in (0.0, 0.4, 0.4):
                path = tmp_path / f"still{suffix}"
                self.still(path, at)
                images.append(self.read(path).astype(int))
            assert np.abs(images[0] - images[1]).max() > 64
            np.testing.assert_array_equal(images[1], images[2])

    def test_a_still_needs_neither_a_path_nor_a_pipe(self, tmp_path: Path) -> None:
        """A still may show a flight of one sample, and a flight in open water."""
        for suffix in self.plugin().stills:
            path = tmp_path / f"still{suffix}"
            self.still(path, 0.0, trajectory=first_sample(drifting_trajectory()))
            assert len(self.read(path)) == 1
            self.still(path, 0.0, scenario=Scenario())
            assert len(self.read(path)) == 1

    @pytest.mark.parametrize("name", ["still.mkw", "still", "still.", ".png"])
    def test_an_unknown_suffix_of_a_still_is_refused(self, name: str, tmp_path: Path) -> None:
        """Every suffix is unknown to a renderer that makes no stills; nothing is written."""
        with pytest.raises(InputError):
            self.plugin().check_still(tmp_path / name)
        with pytest.raises(InputError):
            self.still(tmp_path / name)
        assert list(tmp_path.iterdir()) == []
