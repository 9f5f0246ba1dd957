"""The contents of a film, and the shapes that both views share."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from driftform.figures import style
from driftform.motion import path
from driftform.types import Agent, FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Scenario
from driftform_exudyn.shapes import Shape, make_ball, make_text
from driftform_exudyn.surroundings import Bore, list_bores, upright_axes

PER_FRAME = 8
"""Segments of the line along the path for each frame."""


@dataclass(frozen=True, eq=False)
class Pose:
    """The ``position`` of the core's centre (world, m, (3,)) and the ``rotation``, body to world, (3, 3)."""

    position: FloatArray
    rotation: FloatArray


def interpolate_poses(trajectory: Trajectory, t: FloatArray) -> list[Pose]:
    """Return the poses at times ``t`` (s, (n,)), by the cubic interpolation that fitness uses for the path."""
    turned = rotations.matrix_from_quaternion(path.interpolate_attitudes(trajectory, t))
    return [Pose(*pose) for pose in zip(path.interpolate_positions(trajectory, t), turned, strict=True)]


@dataclass(frozen=True, eq=False)
class Scene:
    """An agent, its flight and surroundings, the time of each frame, s, (n,), and the height of letters, px.

    ``still`` is the frame of a still, which shows the whole path; ``None`` for a film.
    """

    agent: Agent
    trajectory: Trajectory
    scenario: Scenario
    t: FloatArray
    letter_height: float
    still: int | None = None

    @property
    def line_width(self) -> float:
        """Width of lines, px, in proportion to the letters."""
        return max(2.0, 0.2 * self.letter_height)

    @cached_property
    def axes(self) -> FloatArray:
        """Right (downstream), up, and towards the viewer in the world frame: rows, (3, 3)."""
        return upright_axes(self.scenario)

    @cached_property
    def poses(self) -> list[Pose]:
        """The agent's pose at each frame."""
        return interpolate_poses(self.trajectory, self.t)

    @cached_property
    def path(self) -> FloatArray:
        """Points of the path of the core's centre, ``PER_FRAME`` for each frame, world, m, (k, 3)."""
        frames = np.arange(len(self.t))
        between = np.linspace(0, len(self.t) - 1, PER_FRAME * (len(self.t) - 1) + 1)
        return path.interpolate_positions(self.trajectory, np.interp(between, frames, self.t))

    def path_until(self, frame: int) -> FloatArray:
        """Return the path up to a frame, or the whole path for a still, world, m, (k, 3)."""
        return self.path if self.still is not None else self.path[: PER_FRAME * frame + 1]

    @cached_property
    def bores(self) -> list[Bore]:
        """The pipe, seen from the side."""
        return list_bores(self.scenario.pipe, self.axes[2])

    def make_targets(self, radius: float, focus: FloatArray, near: float = np.inf) -> list[Shape]:
        """Return the targets within ``near`` (m) of ``focus`` as balls of ``radius`` (m), with their names."""
        shapes = []
        for name, place in self.scenario.target_points().items():
            if np.linalg.norm(focus - place) < near:
                beside = np.array(place) + 1.6 * radius * self.axes[0]
                shapes += [
                    make_ball(place, radius, style.VERMILLION),
                    make_text(beside, name, style.INK, self.letter_height),
                ]
        return shapes

    def format_caption(self, frame: int) -> str:
        """Return the time and the position of the core's centre as text."""
        where = zip("xyz", self.poses[frame].position, strict=True)
        return "   ".join([f"t {self.t[frame]:.2f} s", *(f"{name} {value:.2f} m" for name, value in where)])
