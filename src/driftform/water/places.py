"""Places in a pipe by name: so far into a part, in the direction of an hour, so far off the wall."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError, model_validator

from driftform.errors import did_you_mean
from driftform.types import FloatArray
from driftform.util.options import Table, option
from driftform.water.parts.layout import Layout
from driftform.water.parts.shapes import exact_cosine, exact_sine, upright_axes

_STEPS = 400
"""Points of a part's axis."""


class Place(Table):
    """A point of a pipe, by the name of a part."""

    part: str = option("", "name of the part, as `scenarios show` lists them", min_length=1)
    at: float = option(0.0, "distance from the upstream end of the part, along its axis", "m", ge=0, le=1e5)
    clock: float = option(
        12.0, "direction from the axis as on a clock seen downstream: 12 is the crown, 6 the floor", "h", ge=0, le=12
    )
    off_wall: float | None = option(None, "distance from the wall; the axis by default", "m", ge=0, le=100)
    branch: bool = option(False, "whether it lies in the branch of a junction")

    @model_validator(mode="before")
    @classmethod
    def _needs_a_part(cls, values: Any) -> Any:
        if isinstance(values, Mapping) and "part" not in values:
            raise ValueError("a place needs 'part', the name of a part")
        return values

    def find_point(self, layout: Layout) -> FloatArray:
        """Return the point in the world frame, m, (3,).

        Raises ValueError if there is no such part, or the place is beyond its end or its axis.
        """
        parts = {placed.name: placed.part for placed in layout.parts}
        if self.part not in parts:
            raise ValueError(
                f"no part is called '{self.part}'{did_you_mean(self.part, parts)}; there are {', '.join(parts)}"
            )
        axes = parts[self.part].list_axes(max(parts[self.part].length, 1e-9) / _STEPS)
        if self.branch and len(axes) == 1:
            raise ValueError(f"'{self.part}' has no branch")
        axis = axes[int(self.branch)]
        along = axis.lengths
        if self.at > along[-1] + 1e-9:
            raise ValueError(f"at = {self.at:g} is beyond the end of '{self.part}', which is {along[-1]:.4g} m long")
        centre = np.array([np.interp(self.at, along, column) for column in axis.points.T])
        radius = float(np.interp(self.at, along, axis.radii))
        if self.off_wall is None:
            return centre
        if self.off_wall > radius:
            raise ValueError(
                f"off_wall = {self.off_wall:g} is beyond the axis: the bore has a radius of {radius:.4g} m there"
            )
        index = min(int(np.searchsorted(along, self.at, side="right")), len(along) - 1)
        _, left, up = upright_axes(axis.points[index] - axis.points[max(index - 1, 0)])
        turn = np.pi / 6 * self.clock
        outward = exact_cosine(turn) * up - exact_sine(turn) * left
        return np.asarray(centre + (radius - self.off_wall) * outward)


def resolve_place(value: Any, layout: Layout) -> Any:
    """Return the coordinates (m) of a place that is given as a table; any other value is returned unchanged.

    Raises ValueError if it is not a place in the pipe.
    """
    if not isinstance(value, Mapping):
        return value
    try:
        place = Place.model_validate(value)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key, said = ".".join(map(str, first["loc"])), first["msg"]
        if said.startswith("Input should be"):
            raise ValueError(f"{key} = {first['input']!r}, and {said.removeprefix('Input ')}") from None
        raise ValueError(f"{key}: {said}".removeprefix(": ")) from None
    return place.find_point(layout).tolist()


def find_nearest_inside(point: FloatArray, layout: Layout) -> tuple[FloatArray, float]:
    """Return the point of a pipe that is nearest to a point outside, and how far it is away, m; within 1 % of the bore."""
    best, distance = point, np.inf
    for placed in layout.parts:
        for axis in placed.part.list_axes(max(placed.part.length, 1e-9) / _STEPS):
            # The section of the bore at each point of the axis is a disc.
            way = np.gradient(axis.points, axis=0)
            way /= np.linalg.norm(way, axis=1, keepdims=True)
            across = point - axis.points
            across -= (across * way).sum(axis=1, keepdims=True) * way
            share = np.minimum(1.0, axis.radii / np.maximum(np.linalg.norm(across, axis=1), 1e-12))
            nearest = axis.points + share[:, None] * across
            away = np.linalg.norm(point - nearest, axis=1)
            at = int(away.argmin())
            if away[at] < distance:
                best, distance = nearest[at], float(away[at])
    return np.asarray(best), distance
