"""Contract of renderers."""

import warnings
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import pytest

from driftform.errors import InputError
from driftform.interfaces import Renderer
from driftform.plugins.seams import require_file
from driftform.testing.agents import first_samples, hollow_agent, straight_pipe
from driftform.testing.contract import SeamContract
from driftform.types import End, Trajectory
from driftform.water import Scenario

Frames: TypeAlias = npt.NDArray[np.uint8]
"""Frames of a film, (frames, height, width, 3): red, green and blue."""


def read_film(path: Path) -> Frames:
    """Return the frames of a film, read by the ffmpeg of the package imageio-ffmpeg."""
    from imageio_ffmpeg import read_frames

    with warnings.catch_warnings():
        # It leaves its pipes to be closed by the interpreter.
        warnings.simplefilter("ignore", ResourceWarning)
        facts, *frames = read_frames(path, output_params=["-fps_mode", "passthrough"])
    width, height = facts["size"]
    return np.frombuffer(b"".join(frames), np.uint8).reshape(-1, height, width, 3)


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
        scenario: that of the flights: half a metre of pipe, with a target.
    """

    rate: float = 25.0
    size: tuple[int, int] = (640, 360)
    scenario = Scenario(pipe=straight_pipe(0.5, 0.1), targets={"leak": (0.3, 0.0, 0.05)})

    def read(self, path: Path) -> Frames:
        """Return the frames of a film; override it for formats that ffmpeg does not read."""
        return read_film(path)

    def make(
        self,
        path: Path,
        trajectory: Trajectory | None = None,
        scenario: Scenario | None = None,
        at: float | None = None,
        renderer: Renderer[Any] | None = None,
    ) -> Frames:
        """Make a film, or a still at a time (s), of a flight that by default drifts and pitches; return its frames."""
        renderer, name = renderer or self.plugin(), "film" if at is None else "still"
        last = (lambda done, total: None) if at is None else at
        flight = (hollow_agent(), trajectory or drifting_trajectory(), scenario or self.scenario)
        written = require_file(getattr(renderer, name)(*flight, path, last), renderer, name)
        assert Path(written.path) == path and written.format == renderer.name
        return self.read(path)

    def frames(self, folder: Path, **given: Any) -> npt.NDArray[np.int_]:
        """Return the frames of a film in the first of the formats, whose differences may be negative."""
        return self.make(folder / f"film{self.plugin().suffixes[0]}", **given).astype(int)

    def test_each_format_gives_a_film_where_it_was_asked_for(self, tmp_path: Path) -> None:
        """A film has the frames of its duration, within one for the ends, replaces an older one, and is the only file."""
        renderer = self.plugin()
        assert renderer.suffixes
        for suffix in renderer.suffixes:
            path = tmp_path / suffix / f"film{suffix}"
            path.parent.mkdir()
            path.write_bytes(b"old " * 1_000_000)
            renderer.check(path)
            frames = self.make(path)
            assert abs(len(frames) - self.rate * drifting_trajectory().t[-1]) <= 1
            assert frames.shape[1:] == (self.size[1], self.size[0], 3)
            assert list(path.parent.iterdir()) == [path] and path.stat().st_size < 4_000_000

    def test_motion_and_attitude_are_visible(self, tmp_path: Path) -> None:
        """Consecutive frames differ clearly, and so do the last frames of flights with and without a turn by a right angle."""
        straight, turned = (
            self.frames(tmp_path, trajectory=drifting_trajectory(turn=turn)) for turn in (0.0, np.pi / 2)
        )
        assert (np.abs(np.diff(straight, axis=0)).max(axis=(1, 2, 3)) > 32).all()
        assert np.abs(straight[-1] - turned[-1]).max() > 64

    def test_the_same_flight_gives_the_same_frames(self, tmp_path: Path) -> None:
        """A renderer that was sent to another process makes the same frames."""
        np.testing.assert_array_equal(self.frames(tmp_path), self.frames(tmp_path, renderer=self.copy()))

    def test_a_flight_of_one_sample_and_open_water_are_shown_too(self, tmp_path: Path) -> None:
        """A flight that ended at its release has one sample, and a scenario needs neither pipe nor targets."""
        least: dict[str, Any] = {"trajectory": first_samples(drifting_trajectory()), "scenario": Scenario()}
        for key, value in least.items():
            assert len(self.frames(tmp_path, **{key: value})) >= 1
            for suffix in self.plugin().stills:
                assert len(self.make(tmp_path / f"still{suffix}", at=0.0, **{key: value})) == 1

    @pytest.mark.parametrize("name", ["film.mkw", "film", ".mp4"])
    def test_an_unknown_suffix_is_refused(self, name: str, tmp_path: Path) -> None:
        """``check`` and ``check_still`` refuse it before the flight, and so do ``film`` and ``still``; nothing is written."""
        renderer = self.plugin()
        for check, at in ((renderer.check, None), (renderer.check_still, 0.0)):
            with pytest.raises(InputError):
                check(tmp_path / name)
            with pytest.raises(InputError):
                self.make(tmp_path / name, at=at)
        assert list(tmp_path.iterdir()) == []

    def test_a_still_shows_the_moment_that_was_asked_for(self, tmp_path: Path) -> None:
        """It has the size of a film; release and end differ, and the same moment always gives the same picture."""
        for suffix in self.plugin().stills:
            path = tmp_path / f"still{suffix}"
            self.plugin().check_still(path)
            first, last, again = (self.make(path, at=at).astype(int) for at in (0.0, 0.4, 0.4))
            assert first.shape == (1, self.size[1], self.size[0], 3)
            assert np.abs(first - last).max() > 64
            np.testing.assert_array_equal(last, again)
            assert list(tmp_path.iterdir()) == [path]
            path.unlink()
