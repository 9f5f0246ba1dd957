"""Files of tracks: plain CSV, and what Tracker and DeepLabCut export.

Plain CSV has a row of names, then ``t, x, y``, ``t, x, y, z`` or a part of them, with ``pitch`` or ``angle`` if it was
measured; several points are named as in ``nose_x, nose_y``. Tracker writes the name of the track above the names of the
columns. DeepLabCut writes rows ``scorer``, ``individuals`` (with several animals), ``bodyparts`` and ``coords``, and
numbers frames. Cells are separated by commas, semicolons, tabs or spaces; with the others, numbers may have decimal commas.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.types import FloatArray
from driftform.util import files

TIMES = ("t", "time", "times", "seconds", "sec")
FRAMES = ("frame", "frames", "frame_number", "step", "n")
ANGLES = {"pitch": -1.0, "angle": 1.0, "theta": 1.0, "θ": 1.0}
"""Columns of an angle, and its sign: a positive pitch is nose down, other angles are counterclockwise."""

_UNIT = re.compile(r"[\s_]*[\[(]\s*([^\])]*?)\s*[\])]\s*$")
_NUMBER = re.compile(r"^[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?$|^[+-]?(nan|inf)$", re.IGNORECASE)
_LENGTHS, _ANGLE_UNITS = ("m", "cm", "mm", "px"), {"deg": np.pi / 180, "°": np.pi / 180, "rad": 1.0}


@dataclass(frozen=True, eq=False)
class TrackTable:
    """The numbers of a file, as they are in it.

    Attributes
    ----------
    t
        times, s, or numbers of frames, (n,).
    points
        coordinates of each named point, NaN where there are none: (n, 2), or (n, 3) in space.
    angle
        rad, counterclockwise from the right, (n,); NaN without one.
    likelihood
        of each point, (n,), if the file has it.
    is_frames
        whether ``t`` counts frames.
    is_image
        whether the coordinates are those of a picture, with y downward.
    unit
        of lengths as the file names it, ``""`` if it does not.
    """

    t: FloatArray
    points: dict[str, FloatArray]
    angle: FloatArray
    likelihood: dict[str, FloatArray] = field(default_factory=dict)
    is_frames: bool = False
    is_image: bool = False
    unit: str = ""
    notes: tuple[str, ...] = ()

    @property
    def is_spatial(self) -> bool:
        """True if the points have three coordinates."""
        return bool(next(iter(self.points.values())).shape[1] == 3)


def read_table(path: Path, target: str | None = None) -> TrackTable:
    """Read the numbers of a file; ``target`` names the tracked object if there are several.

    Raises
    ------
    InputError
        if it is no such file.
    """
    rows = _split_rows(files.read_text(path))
    if not rows:
        raise InputError(f"{path}: is empty")
    if rows[0][0].lower() == "scorer":
        return _read_deeplabcut(path, rows, target)
    return _read_columns(path, rows, target)


def _split_rows(text: str) -> list[list[str]]:
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("#", "//"))]
    sample = lines[:20]
    for delimiter in ("\t", ";", ","):
        # A decimal comma is no delimiter: tabs and semicolons go first.
        if sum(delimiter in line for line in sample) > len(sample) / 2:
            return [[cell.strip().strip('"') for cell in line.split(delimiter)] for line in lines]
    return [line.split() for line in lines]


def _read_number(cell: str) -> float:
    """Return a cell as a number, NaN if it is not one."""
    return float(cell.replace(",", ".")) if _NUMBER.match(cell) else float("nan")


def _read_numbers(path: Path, rows: Sequence[Sequence[str]], width: int) -> FloatArray:
    numbers = np.full((len(rows), width), np.nan)
    for k, row in enumerate(rows):
        for j, cell in enumerate(row[:width]):
            numbers[k, j] = _read_number(cell)
    numbers[np.isinf(numbers)] = np.nan
    if not np.isfinite(numbers).any():
        raise InputError(f"{path}: holds no numbers below its names")
    return numbers


def _read_deeplabcut(path: Path, rows: list[list[str]], target: str | None) -> TrackTable:
    heads = {
        row[0].lower(): row for row in rows[:4] if row[0].lower() in ("individuals", "bodyparts", "coords")
    }
    if "bodyparts" not in heads or "coords" not in heads:
        raise InputError(
            f"{path}: begins as an export of DeepLabCut, and has no rows 'bodyparts' and 'coords'"
        )
    parts, coords = heads["bodyparts"], [name.lower() for name in heads["coords"]]
    columns = list(range(1, min(len(parts), len(coords))))
    if (animals := heads.get("individuals")) is not None:
        wanted = _choose(path, [animals[j] for j in columns], target)
        columns = [j for j in columns if animals[j] == wanted]
    numbers = _read_numbers(path, rows[1 + len(heads) :], max(columns, default=0) + 1)
    points: dict[str, FloatArray] = {}
    likelihood: dict[str, FloatArray] = {}
    for name in dict.fromkeys(parts[j] for j in columns):
        of = {coords[j]: numbers[:, j] for j in columns if parts[j] == name}
        if "x" in of and "y" in of:
            points[name] = np.column_stack([of["x"], of["y"]])
            if "likelihood" in of:
                likelihood[name] = of["likelihood"]
    if not points:
        raise InputError(f"{path}: has no body part with x and y")
    t, angle = numbers[:, 0], np.full(len(numbers), np.nan)
    return TrackTable(t, points, angle, likelihood, is_frames=True, is_image=True, unit="px")


def _choose(path: Path, objects: Sequence[str], target: str | None) -> str:
    """Return the tracked object to read, by its name if there are several."""
    names = list(dict.fromkeys(name for name in objects if name))
    if target is not None:
        if target not in names:
            raise InputError(f"--object {target}: {path} has no such object{did_you_mean(target, names)}")
        return target
    if len(names) > 1:
        raise InputError(
            f"{path}: follows {len(names)} objects ({', '.join(names)}); choose one with --object NAME"
        )
    return names[0] if names else ""


@dataclass(frozen=True)
class _Column:
    """What a column holds: ``t``, ``frame``, ``angle``, or the coordinate ``x``, ``y`` or ``z`` of a point."""

    kind: str
    point: str = ""
    unit: str = ""
    factor: float = 1.0


def _name_column(text: str) -> _Column | None:
    name, unit = text.strip().lower(), ""
    if (found := _UNIT.search(name)) is not None:
        name, unit = name[: found.start()], found.group(1)
    for suffix in (*_LENGTHS, *_ANGLE_UNITS, "s"):
        if name.endswith(f"_{suffix}"):
            name, unit = name[: -len(suffix) - 1], suffix
    if name in TIMES:
        return _Column("t", unit=unit, factor=0.001 if unit == "ms" else 1.0)
    if name in FRAMES:
        return _Column("frame")
    if name in ANGLES:
        return _Column("angle", unit=unit, factor=ANGLES[name] * _ANGLE_UNITS.get(unit, 1.0))
    point, _, axis = name.rpartition("_") if "_" in name else name.rpartition(".")
    unit = {"pixel": "px", "pixels": "px"}.get(unit, unit)
    return _Column(axis, point, unit) if axis in ("x", "y", "z") else None


def _read_columns(path: Path, rows: list[list[str]], target: str | None) -> TrackTable:
    head, columns, notes = _find_names(path, rows)
    objects = [""] * len(columns)
    if head > 0:
        objects = _spread_names(rows[head - 1], len(columns))
        pairs = list(zip(objects, columns, strict=True))
        if len({name for name, column in pairs if column and column.kind in "xyz"}) > 1:
            chosen = _choose(path, objects, target)
            columns = [
                column if column and (name == chosen or column.kind in ("t", "frame")) else None
                for name, column in pairs
            ]
    places: dict[tuple[str, str], int] = {}
    for j, column in enumerate(columns):
        if column is None:
            continue
        key = (column.kind, column.point)
        if key in places and column.kind in "xyz":
            raise InputError(f"{path}: has two columns {column.kind}, as of two objects; keep those of one")
        places.setdefault(key, j)
    numbers = _read_numbers(path, rows[head + 1 :], len(columns))
    is_frames = ("t", "") not in places
    t = numbers[:, places[("frame" if is_frames else "t", "")]]
    time = columns[places[("t", "")]] if not is_frames else None
    units = {column.unit for column in columns if column is not None and column.kind in "xyz" and column.unit}
    if len(units) > 1:
        raise InputError(f"{path}: its coordinates have several units: {', '.join(sorted(units))}")
    angle = np.full(len(numbers), np.nan)
    if ("angle", "") in places:
        j = places[("angle", "")]
        angle = numbers[:, j] * (columns[j] or _Column("angle")).factor
    return TrackTable(
        t * (time.factor if time else 1.0),
        _gather_points(path, places, numbers),
        angle,
        is_frames=is_frames,
        unit=next(iter(units), ""),
        notes=tuple(notes),
    )


def _find_names(path: Path, rows: list[list[str]]) -> tuple[int, list[_Column | None], list[str]]:
    """Return the row of names (-1 without one), what its columns hold, and notes."""
    for k, row in enumerate(rows[:10]):
        columns = [_name_column(cell) for cell in row]
        kinds = {column.kind for column in columns if column is not None}
        if kinds & {"t", "frame"} and kinds & {"x", "y", "z"}:
            return k, columns, []
    width = len(rows[0])
    if 3 <= width <= 4 and all(np.isfinite(_read_number(cell)) for cell in rows[0]):
        names = ("t", "x", "y", "z")[:width]
        return (
            -1,
            [_Column(name) for name in names],
            [f"no row of names: columns are taken as {', '.join(names)}"],
        )
    first = ", ".join(rows[0])[:60]
    raise InputError(
        f"{path}: no row names its columns: expected t (or frame) with x, y or z, found '{first}'"
    )


def _spread_names(row: Sequence[str], width: int) -> list[str]:
    """Return the name of the object above each column: a name holds until the next."""

    def hold(last: str, cell: str) -> str:
        return cell or last

    return list(accumulate([*row, *[""] * width][:width], hold))


def _gather_points(
    path: Path, places: dict[tuple[str, str], int], numbers: FloatArray
) -> dict[str, FloatArray]:
    points: dict[str, FloatArray] = {}
    nothing = np.full(len(numbers), np.nan)
    names = dict.fromkeys(point for kind, point in places if kind in ("x", "y", "z"))
    for point in names:
        x, y, z = (numbers[:, places[(k, point)]] if (k, point) in places else nothing for k in "xyz")
        if ("z", point) in places and ("y", point) in places:
            points[point] = np.column_stack([x, y, z])
        else:
            # A picture's second coordinate is its height, whether it is called y or z.
            points[point] = np.column_stack([x, z if ("z", point) in places else y])
    if len({values.shape[1] for values in points.values()}) > 1:
        raise InputError(f"{path}: some of its points have three coordinates, and some two")
    return points
