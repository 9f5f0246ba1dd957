"""The pipe: straight segments with a circular bore."""

from typing import Annotated, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from driftform.options import Table, option
from driftform.types import FloatArray

Number: TypeAlias = Annotated[float, Field(strict=True, ge=-1e6, le=1e6)]
"""A number; text such as "1.0" is not accepted."""

Vector: TypeAlias = tuple[Number, Number, Number]
"""A vector in the world frame."""


class Segment(Table):
    """One straight segment of pipe with a circular bore."""

    start: Vector = option(..., "centre of the upstream end", "m")
    end: Vector = option(..., "centre of the downstream end", "m")
    radius: float = option(..., "inner radius", "m", ge=1e-3, le=100, strict=True)

    @model_validator(mode="after")
    def _check_length(self) -> "Segment":
        if self.start == self.end:
            raise ValueError("start and end of a pipe segment are the same point")
        return self


def _contains(segment: Segment, point: Vector) -> bool:
    start, end = np.array(segment.start), np.array(segment.end)
    axis = (end - start) / np.linalg.norm(end - start)
    along = float(axis @ (point - start))
    across = float(np.linalg.norm(point - start - along * axis))
    length = float(np.linalg.norm(end - start))
    return -1e-9 <= along <= length + 1e-9 and across <= segment.radius


class Pipe(Table):
    """A chain of segments from the inlet to the outlet; open water without segments."""

    segments: tuple[Segment, ...] = option((), "segments from the inlet to the outlet", max_length=1)

    def array(self) -> FloatArray:
        """Return rows of start (3), end (3) and radius, m, (segments, 7)."""
        rows = [(*s.start, *s.end, s.radius) for s in self.segments]
        return np.array(rows, dtype=np.float64).reshape(-1, 7)

    def contains(self, point: Vector) -> bool:
        """Return whether a point lies inside a segment or on its wall."""
        return any(_contains(segment, point) for segment in self.segments)

    def farthest_distance(self, point: FloatArray) -> float:
        """Return the distance from ``point`` to the farthest point of the pipe's volume, m, infinite in open water.

        The distance is convex, so its maximum over a cylinder lies on the rim of an end. From a point at axial offset
        h and distance s from the axis, the farthest point of an end disc is the rim point on the opposite side of the
        axis, at sqrt(h^2 + (s + R)^2).
        """
        best = 0.0 if self.segments else np.inf
        for segment in self.segments:
            start, end = np.array(segment.start), np.array(segment.end)
            n = (end - start) / np.linalg.norm(end - start)
            for centre in (start, end):
                h = float(n @ (point - centre))
                s = float(np.linalg.norm(point - centre - h * n))
                best = max(best, float(np.hypot(h, s + segment.radius)))
        return best
