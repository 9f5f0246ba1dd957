"""The pipe: one straight segment, or parts laid end to end."""

from functools import lru_cache
from typing import Annotated, Any, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from driftform.types import FloatArray
from driftform.util.latest import keep_latest
from driftform.util.options import Table, describe, option
from driftform.water.parts.layout import Layout, lay_out
from driftform.water.parts.tables import PARTS, PartTable, StraightPart

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


class Pipe(Table):
    """A pipe from the inlet to its outlets: one segment by its coordinates, or parts; open water without either."""

    segments: tuple[Segment, ...] = option((), "the segment of a straight pipe, by its coordinates", max_length=1)
    radius: float | None = option(
        None, "radius of the bore at the inlet, of a pipe with parts", "m", ge=1e-3, le=100, strict=True
    )
    start: Vector | None = option(None, "centre of the inlet of a pipe with parts; by default the origin", "m")
    direction: Vector | None = option(
        None, "direction downstream at the inlet of a pipe with parts; by default along x"
    )
    parts: tuple[PartTable, ...] = option((), "parts from the inlet on, laid end to end")

    @staticmethod
    def describe_parts() -> dict[str, list[dict[str, Any]]]:
        """Return the options of each kind of part: rows ``{option, type, bounds, default, unit, help}``."""
        return {kind: describe(model) for kind, model in PARTS.items()}

    @model_validator(mode="after")
    def _check_parts(self) -> "Pipe":
        if not self.parts:
            for name in ("radius", "start", "direction"):
                if getattr(self, name) is not None:
                    raise ValueError(f"pipe.{name} is for a pipe with parts: add [[pipe.parts]]")
            return self
        if self.segments:
            raise ValueError(
                "pipe.segments and pipe.parts describe the same pipe: remove one of them (pipe.segments = [])"
            )
        if self.radius is None:
            raise ValueError("pipe.radius is missing: the radius of the bore at the inlet of a pipe with parts, m")
        if self.direction is not None and not np.linalg.norm(self.direction) > 1e-9:
            raise ValueError("pipe.direction has no length")
        _lay_out(self)
        return self

    @property
    def is_open(self) -> bool:
        """True in open water."""
        return not self.segments and not self.parts

    @property
    def layout(self) -> Layout:
        """The parts in their places; a segment is a straight part. Empty in open water."""
        return _lay_out(self)

    @property
    def straight(self) -> Segment | None:
        """The whole pipe as one segment, if it is straight with one bore; ``None`` otherwise."""
        if self.segments:
            return self.segments[0]
        if not self.parts or not all(isinstance(part, StraightPart) for part in self.parts):
            return None
        inlet, outlet = self.layout.inlet, self.layout.outlets[-1].opening
        x, y, z = inlet.centre.tolist()
        u, v, w = outlet.centre.tolist()
        return Segment(start=(x, y, z), end=(u, v, w), radius=inlet.radius)

    def array(self) -> FloatArray:
        """Return start (3), end (3) and radius of a straight pipe, m, (1, 7); (0, 7) for another one and in open water."""
        segment = self.straight
        rows = [] if segment is None else [(*segment.start, *segment.end, segment.radius)]
        return np.array(rows, dtype=np.float64).reshape(-1, 7)

    def contains(self, point: Vector) -> bool:
        """Return whether a point lies inside the pipe or on its wall."""
        return bool(self.layout.find_part(np.array([point]))[0] >= 0)

    def farthest_distance(self, point: FloatArray) -> float:
        """Return the distance from ``point`` to the farthest point of a straight pipe's volume, m, infinite in open water.

        The distance is convex, so its maximum over a cylinder lies on the rim of an end. From a point at axial offset
        h and distance s from the axis, the farthest point of an end disc is the rim point on the opposite side of the
        axis, at sqrt(h^2 + (s + R)^2).
        """
        segment = self.straight
        if segment is None:
            return np.inf
        best = 0.0
        start, end = np.array(segment.start), np.array(segment.end)
        n = (end - start) / np.linalg.norm(end - start)
        for centre in (start, end):
            h = float(n @ (point - centre))
            s = float(np.linalg.norm(point - centre - h * n))
            best = max(best, float(np.hypot(h, s + segment.radius)))
        return best


@keep_latest
@lru_cache(maxsize=32)
def _lay_out(pipe: Pipe) -> Layout:
    if pipe.parts:
        assert pipe.radius is not None
        start, direction = pipe.start or (0.0, 0.0, 0.0), pipe.direction or (1.0, 0.0, 0.0)
        return lay_out(pipe.parts, np.array(start), np.array(direction), pipe.radius)
    for segment in pipe.segments:
        axis = np.subtract(segment.end, segment.start, dtype=np.float64)
        part = StraightPart.model_construct(length=float(np.linalg.norm(axis)))
        return lay_out([part], np.array(segment.start), axis, segment.radius)
    return Layout((), ())
