"""The profile of a body of revolution, from points in a CSV file or from the solid in a mesh or a STEP file."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform.util import files, foreign
from driftform_frusta.own.revolved import find_profile, simplify_contour
from driftform_frusta.own.third_party import MESHES, read_triangles

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
"""Units of length of a file, m."""

MAX_DEVIATION = 0.02
"""Greatest distance from a solid of revolution that is accepted, over the diameter."""

MAX_FINS = 0.75
"""The same for a body with fins, whose coefficients are known."""

MIN_LENGTH, MAX_LENGTH = 5e-3, 20.0
"""Bounds of a body's length or diameter, the greater of both, m."""


@dataclass(frozen=True, eq=False)
class Profile:
    """The profile of a body of revolution.

    ``points`` are distance from the nose and radius, m, (n, 2), from the nose to the tail, with both ends on the axis;
    ``deviation`` is the greatest distance between the surface of the file and that of revolution, over the diameter, and
    ``axis`` a unit vector from tail to nose in the coordinates of the file: 0 and ``None`` for CSV.
    """

    points: FloatArray
    deviation: float = 0.0
    axis: tuple[float, ...] | None = None

    @property
    def length(self) -> float:
        """From nose to tail, m."""
        return float(self.points[-1, 0])


def read_profile(path: Path, unit: str | None = None, flip: bool = False, limit: float = MAX_DEVIATION) -> Profile:
    """Read the profile of a body of revolution.

    ``path`` is that of a CSV file with the columns ``x_mm,r_mm`` or ``x_m,r_m``, x from the nose, or of a closed mesh or
    STEP; ``unit`` is one of :data:`UNITS`, for a mesh: by default mm, and m for GLB; ``flip`` exchanges nose and tail;
    ``limit`` is the greatest deviation that is accepted. An :class:`~driftform.errors.InputError` names the file, and what
    is wrong.
    """
    suffix = path.suffix.lower()
    if unit is not None and unit not in UNITS:
        raise InputError(f"--unit {unit}: unknown unit; choose from {', '.join(UNITS)}")
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    if suffix != ".csv" and suffix not in MESHES:
        kinds = ", ".join((".csv", *MESHES))
        raise InputError(
            f"{path}: unknown format '{suffix}' of a profile; choose from {kinds}, or export it as one of these"
        )
    try:
        if suffix == ".csv":
            profile = Profile(_read_points(path))
        else:
            unit = unit or ("m" if suffix == ".glb" else "mm")
            # A damaged file may keep its reader busy for ever; a sound one takes 5 to 10 s for each megabyte.
            seconds = min(5 + path.stat().st_size // 65_000, 120)
            triangles = UNITS[unit] * foreign.call_apart(read_triangles, path, seconds=seconds, memory=1 << 32)
            profile = Profile(*find_profile(triangles, limit))
    except (ValueError, csv.Error) as error:
        raise InputError(f"{path}: {error}") from None
    largest = max(profile.length, 2 * float(profile.points[:, 1].max()))
    if not MIN_LENGTH <= largest <= MAX_LENGTH:
        advice = "check x_mm and x_m"
        if suffix != ".csv":
            size = largest / UNITS[unit or "mm"]
            likely = [name for name, factor in UNITS.items() if MIN_LENGTH <= size * factor <= MAX_LENGTH]
            advice = f"is it in {' or '.join(likely)}? set --unit" if likely else "set --unit"
        raise InputError(
            f"{path}: is {largest:.4g} m at its largest; a body has {MIN_LENGTH:g} to {MAX_LENGTH:g} m: {advice}"
        )
    points, axis = simplify_contour(profile.points), profile.axis
    if flip:
        points = points[::-1] * [-1.0, 1.0] + [profile.length, 0.0]
        axis = axis and tuple(-c for c in axis)
    return Profile(points, profile.deviation, axis)


def _read_points(path: Path) -> FloatArray:
    """Return distance from the nose and radius, m, closed to the axis at both ends, (n, 2)."""
    text = files.read_text(path)
    head = text.lstrip().partition("\n")[0]
    delimiter = max(",;\t", key=head.count)
    rows = list(csv.reader(text.splitlines(), delimiter=delimiter))
    names = [name.strip().lower() for name in rows[0]] if rows else []
    unit = next((u for u in ("mm", "m") if {f"x_{u}", f"r_{u}"} <= set(names)), None)
    if unit is None:
        raise ValueError(f"its first line is '{head.strip()[:60]}'; it must name the columns x_mm,r_mm or x_m,r_m")
    columns = [names.index(f"{name}_{unit}") for name in "xr"]
    points: list[tuple[float, float]] = []
    for number, row in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in row) or row[0].lstrip().startswith("#"):
            continue
        try:
            x, r = (float(row[column].replace(",", ".")) * UNITS[unit] for column in columns)
        except (ValueError, IndexError):
            raise ValueError(f"line {number} has no two numbers: '{delimiter.join(row)[:60]}'") from None
        if not (math.isfinite(x) and math.isfinite(r) and r >= 0):
            raise ValueError(f"line {number}: x must be a number, and the radius a number from 0")
        if points and x < points[-1][0]:
            raise ValueError(f"line {number}: x falls to {row[columns[0]].strip()}; x grows from the nose to the tail")
        points.append((x, r))
    if len(points) < 2 or max(r for _, r in points) == 0 or points[0][0] == points[-1][0]:
        raise ValueError("it needs at least two points at different x, and a radius above 0")
    closed = np.array([(points[0][0], 0.0), *points, (points[-1][0], 0.0)])
    closed[:, 0] -= points[0][0]
    if (closed[2:-2, 1] == 0).any():
        raise ValueError("the radius is 0 between nose and tail: that is two bodies")
    return closed
