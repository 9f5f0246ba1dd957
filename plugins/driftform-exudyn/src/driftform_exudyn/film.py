"""A flight as a film or as a still, by Exudyn's ray tracer."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from driftform.errors import WorkFailedError
from driftform.interfaces import Renderer, Table, option
from driftform.types import Agent, Trajectory, WrittenFile
from driftform.util import files
from driftform.water import Scenario
from driftform_exudyn.encoder import SUFFIXES, encode, find_ffmpeg, png_bytes

if TYPE_CHECKING:
    from driftform_exudyn.scene import Scene
    from driftform_exudyn.stage import Image

PATH_STEP = 0.04
"""Time between two points of the path on a still, s."""


class FilmOptions(Table):
    """Size, speed and view of a film."""

    width: int = option(800, "width of the film", "px", ge=64, le=4096, multiple_of=2)
    height: int = option(500, "height of the film", "px", ge=64, le=4096, multiple_of=2)
    fps: float = option(25.0, "frames per second of the film", "1/s", gt=0, le=120)
    speed: float = option(
        1.0, "seconds of the flight per second of the film; less than 1 is slow motion", "", ge=0.001, le=1000
    )
    view: Literal["both", "follow", "side"] = option(
        "both", "'follow': close view of the agent; 'side': the whole pipe; 'both': the first above the second"
    )
    rays: int = option(2, "rays along each side of a pixel: more rays give smoother edges and take longer", ge=1, le=4)


class ExudynRenderer(Renderer[FilmOptions]):
    """A film or a still by Exudyn's ray tracer, which needs no display; ffmpeg encodes films.

    The agent's modules have two alternating shades, its fore end is blue; the pipe is cut open, with equally spaced rings.
    """

    name = "exudyn"
    suffixes = SUFFIXES
    stills = (".png",)
    Options = FilmOptions

    def check(self, path: Path) -> None:
        """Raise an error for other suffixes, and for any film if ffmpeg is not installed."""
        super().check(path)
        find_ffmpeg()

    def film(
        self, agent: Agent, trajectory: Trajectory, scenario: Scenario, path: Path, progress: Callable[[int, int], None]
    ) -> WrittenFile:
        """Write the film. Facts: ``frames``, ``seconds`` of the film, ``size_px``."""
        from driftform.motion.path import even_times
        from driftform_exudyn.scene import Scene

        self.check(path)
        size, fps = self._size, self.options.fps
        t = even_times(float(trajectory.t[-1]), self.options.speed / fps)
        scene = Scene(agent, trajectory, scenario, t, self._letter_height)

        def render_all() -> "Iterator[Image]":
            for done, image in enumerate(map(self._make_view(scene), range(len(t))), start=1):
                yield image
                progress(done, len(t))

        _save(path, lambda part: encode(render_all(), part, path.suffix.lower(), fps))
        return WrittenFile(self.name, str(path), {"frames": len(t), "seconds": len(t) / fps, "size_px": size})

    def still(self, agent: Agent, trajectory: Trajectory, scenario: Scenario, path: Path, at: float) -> WrittenFile:
        """Write the still; the side view also shows the agent at equal intervals. Facts: ``t``, ``size_px``."""
        from driftform.motion.path import even_times
        from driftform_exudyn.scene import Scene

        self.check_still(path)
        t = np.union1d(even_times(float(trajectory.t[-1]), PATH_STEP), at)
        moment = int(np.searchsorted(t, at))
        scene = Scene(agent, trajectory, scenario, t, self._letter_height, moment)
        picture = png_bytes(self._make_view(scene)(moment))
        _save(path, lambda part: part.write_bytes(picture))
        return WrittenFile(self.name, str(path), {"t": at, "size_px": self._size})

    @property
    def _size(self) -> list[int]:
        return [self.options.width, self.options.height]

    @property
    def _letter_height(self) -> float:
        return min(24.0, max(8.0, self._size[0] / 64), min(self._size) / 16)

    def _make_view(self, scene: "Scene") -> "Callable[[int], Image]":
        """Return the function that renders a frame."""
        from driftform_exudyn.views import FollowView, SideView, wanted_height

        width, height, rays = self.options.width, self.options.height, self.options.rays
        match self.options.view:
            case "follow":
                return FollowView(scene, (width, height), rays).render
            case "side":
                return SideView(scene, (width, height), rays, captioned=True).render
        least = max(0.2 * height, 6 * scene.letter_height)
        low = 2 * round(float(np.clip(wanted_height(scene, width), least, 0.45 * height)) / 2)
        above = FollowView(scene, (width, height - low), rays)
        below = SideView(scene, (width, low), rays, captioned=False)
        return lambda frame: np.concatenate([above.render(frame), below.render(frame)])


def _save(path: Path, write: Callable[[Path], object]) -> None:
    try:
        files.write_whole(path, write)
    except OSError as error:
        raise WorkFailedError(f"cannot write {path}: {error.strerror or error}") from error
