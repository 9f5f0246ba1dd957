"""Files of tracks: plain CSV, and what programs that follow points in films export.

Plain CSV has a row of names, then ``t, x, y``, ``t, x, y, z`` or a part of them; several points are named as in ``nose_x, nose_y``. Tracker writes the name of the track above the names of the
columns, Kinovea before them (``Trajectory 1/0/X``) or after ``#``, idtracker.ai numbers behind them (``x1, y1``), Vernier and Pasco
``VideoAnalysis: X (m)`` and ``X (m) Run #1``. SLEAP,
TrackMate, trackpy and ImageJ have a row for each object and frame, and pixels with y downward. DeepLabCut writes rows ``scorer``, ``individuals`` (with several animals),
``bodyparts`` and ``coords``, and numbers frames, or names their pictures. Cells are separated by commas, semicolons, tabs or
spaces. What the points and commas in numbers mean is found from all of them.
"""

import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.types import FloatArray
from driftform.util import files

MAX_ROWS, MAX_CHARACTERS = 20_000, 20_000_000
"""Most lines and letters of a file: fast cameras take some thousand frames of a fall."""

TIMES = ("t", "time", "times", "timestamp", "seconds", "sec", "position_t")
FRAMES = ("frame", "frames", "frame_number", "frame_idx", "fnum", "step", "n", "slice", "slice n°")
OBJECTS = ("track", "track_id", "track n°", "particle", "object")
"""Columns whose values name the object that a row is of."""

PIXEL_PROGRAMS = (
    *({"frame_idx", "instance.score"}, {"track_id", "position_t"}, {"frame", "particle"}),
    *({"slice"}, {"slice n°"}, {"x1", "y1"}),
)
"""Columns by which SLEAP, TrackMate, trackpy, ImageJ and idtracker.ai are known: coordinates are those of a picture."""

_UNIT = re.compile(r"[\s_]*[\[(]\s*([^\])]*?)\s*[\])]\s*$|\s+/\s*(\w+)\s*$")
_NUMBER = re.compile(r"[+-]?(\d[\d.,'’\u00a0\u202f]*|[.,]\d+)([eE][+-]?\d+)?")
_GROUPS = re.compile(r"(?<=\d)[ '’\u00a0\u202f](?=\d{3}(?!\d))")
_SOURCE = re.compile(r"^.*:\s+|\s+run #\d+$")
_CLOCK = re.compile(r"\d+(:\d\d){1,3}([.,]\d+)?")
_PIXELS = {"pixel": "px", "pixels": "px"}
_SECONDS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0, "h": 3600.0}
_SUFFIXES = ("m", "cm", "mm", "px", "s", "ms")


@dataclass(frozen=True, eq=False)
class TrackTable:
    """The numbers of a file, as they are in it.

    Attributes:
        t: times, s, or numbers of frames, (n,).
        points: coordinates of each named point, NaN where there are none: (n, 2), or (n, 3) in space.
        likelihood: of each point, (n,), if the file has it.
        is_frames: whether ``t`` counts frames.
        is_image: whether the coordinates are those of a picture, with y downward.
        unit: of lengths as the file names it, ``""`` if it does not.
    """

    t: FloatArray
    points: dict[str, FloatArray]
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

    Raises InputError if it is not such a file.
    """
    text = files.read_text(path)
    if len(text) > MAX_CHARACTERS or text.count("\n") > MAX_ROWS:
        raise InputError(
            f"{path}: has more than {MAX_ROWS} rows or {MAX_CHARACTERS // 1_000_000} MB: keep those of one flight"
        )
    try:
        rows = _split_rows(text)
    except csv.Error as error:
        raise InputError(f"{path}: is not a table: {error}") from None
    if not rows:
        raise InputError(f"{path}: is empty")
    if rows[0][0].lower() == "scorer":
        return _read_deeplabcut(path, rows, target)
    return _read_columns(path, rows, target)


def _split_rows(text: str) -> list[list[str]]:
    lines = [line for line in text.splitlines() if line.strip()]
    # Kinovea's names of columns begin as a comment.
    lines = [line for line in lines if not line.lstrip().startswith(("#", "//")) or line.split()[0] == "#T"]
    sample = lines[:20]
    for delimiter in ("\t", ";", ","):
        # A decimal comma is not a delimiter: tabs and semicolons go first, and spaces between names are spaces below them.
        if lines[:1] == ["#T X Y"]:
            break
        if sum(delimiter in line for line in sample) > len(sample) / 2:
            rows = csv.reader(lines, delimiter=delimiter, skipinitialspace=True)
            return [[cell.strip().strip('"') for cell in row] for row in rows]
    return [line.removeprefix("#").split() for line in lines]


def _read_numbers(path: Path, columns: Iterable[Sequence[str]]) -> FloatArray:
    """Return columns of cells as numbers, (rows, columns); NaN for what is not one.

    Raises InputError if a column has cells, and no number.
    """
    columns = [[_GROUPS.sub("", cell) for cell in column] for column in columns]
    cells = [cell for column in columns for cell in column if _NUMBER.fullmatch(cell)]
    decimal, group = _find_marks(path, cells)

    def read(cell: str) -> float:
        if _CLOCK.fullmatch(cell):
            # Such as 1:02.5, or 0:00:01:20 with hundredths at the end, as Kinovea writes it.
            parts = [float(part) for part in cell.replace(",", ".").split(":")]
            last = 0.01 * parts.pop() if len(parts) == 4 else 0.0
            return sum(part * 60.0**k for k, part in enumerate(reversed(parts))) + last
        return float(cell.replace(group, "").replace(decimal, ".")) if _NUMBER.fullmatch(cell) else np.nan

    try:
        numbers = np.array([[read(cell) for cell in column] for column in columns], dtype=np.float64).T
    except ValueError as error:
        raise InputError(f"{path}: holds a number that cannot be read: {error}") from None
    numbers[np.isinf(numbers)] = np.nan
    for column, found in zip(columns, numbers.T, strict=True):
        if not np.isfinite(found).any() and (filled := [k for k, cell in enumerate(column) if cell]):
            raise InputError(
                f"{path}: '{column[filled[0]]}' in row {filled[0] + 1} below the names is not a number: export times in s or as "
                "hh:mm:ss, and places as plain numbers"
            )
    if not np.isfinite(numbers).any():
        raise InputError(f"{path}: holds no numbers below its names")
    return numbers


def _find_marks(path: Path, cells: Sequence[str]) -> tuple[str, str]:
    """Return the decimal mark of numbers, and the mark between thousands (``" "`` if they have none).

    Raises InputError if a comma may be either: one more reading of the numbers would be a thousand times as large.
    """
    both = {("." if cell.rfind(".") > cell.rfind(",") else ",") for cell in cells if "." in cell and "," in cell}
    if len(both) > 1:
        raise InputError(f"{path}: its numbers have decimal points and decimal commas; export it with points alone")
    if both:
        [decimal] = both
        return decimal, "," if decimal == "." else "."
    for group, decimal in ((",", "."), (".", ",")):
        if any(cell.count(group) > 1 for cell in cells):
            return decimal, group
    commas = [cell for cell in cells if "," in cell]
    if not commas:
        return ".", " "
    if not all(re.fullmatch(r"[+-]?[1-9]\d{0,2},\d{3}", cell) for cell in commas):
        return ",", " "
    if any(re.fullmatch(r"[+-]?\d{4,}", cell) for cell in cells):
        return ",", " "
    if any("." in cell for cell in cells):
        return ".", ","
    meant = commas[0].replace(",", ".")
    raise InputError(
        f"{path}: '{commas[0]}' may be {meant} or {meant.replace('.', '')}: export it with decimal points, and without marks "
        "between thousands"
    )


def _read_deeplabcut(path: Path, rows: list[list[str]], target: str | None) -> TrackTable:
    heads = {row[0].lower(): row for row in rows[:4] if row[0].lower() in ("individuals", "bodyparts", "coords")}
    if "bodyparts" not in heads or "coords" not in heads:
        raise InputError(f"{path}: begins as an export of DeepLabCut, and has no rows 'bodyparts' and 'coords'")
    parts, coords = heads["bodyparts"], [name.lower() for name in heads["coords"]]
    # The names of pictures take one column, or three.
    first = next((j for j, name in enumerate(coords) if j and name), 1)
    columns = list(range(first, min(len(parts), len(coords))))
    if (animals := heads.get("individuals")) is not None:
        wanted = _choose(path, [animals[j] for j in columns], target)
        columns = [j for j in columns if animals[j] == wanted]
    body = _even_rows(rows[1 + len(heads) :], max(columns, default=0) + 1)
    counts = zip(*(re.findall(r"\d+", Path(row[first - 1]).stem) for row in body), strict=False)
    # Of several numbers in the names of pictures, that of the frame differs most; in doubt it is the last.
    frames = max(reversed([*counts]), key=lambda texts: len(set(texts)), default=[row[0] for row in body])
    numbers = _read_numbers(path, [frames, *([row[j] for row in body] for j in columns)])
    points: dict[str, FloatArray] = {}
    likelihood: dict[str, FloatArray] = {}
    for name in dict.fromkeys(parts[j] for j in columns):
        of = {coords[j]: numbers[:, k] for k, j in enumerate(columns, 1) if parts[j] == name}
        if "x" in of and "y" in of:
            points[name] = np.column_stack([of["x"], of["y"]])
            if "likelihood" in of:
                likelihood[name] = of["likelihood"]
    if not points:
        raise InputError(f"{path}: has no body part with x and y")
    return TrackTable(numbers[:, 0], points, likelihood, is_frames=True, is_image=True, unit="px")


def _choose(path: Path, objects: Sequence[str], target: str | None) -> str:
    """Return the tracked object to read, by its name if there are several."""
    names = list(dict.fromkeys(name for name in objects if name))
    if target is not None:
        if target not in names:
            raise InputError(f"--object {target}: {path} has no such object{did_you_mean(target, names)}")
        return target
    if len(names) > 1:
        raise InputError(f"{path}: follows {len(names)} objects ({', '.join(names)}); choose one with --object NAME")
    return names[0] if names else ""


@dataclass(frozen=True)
class _Column:
    """What a column holds: ``t``, ``frame``, ``object``, or the coordinate ``x``, ``y`` or ``z`` of a point."""

    kind: str
    point: str = ""
    unit: str = ""


def _name_column(text: str) -> _Column | None:
    name, unit = _SOURCE.sub("", text.strip().lower()), ""
    if (found := _UNIT.search(name)) is not None:
        name, unit = name[: found.start()], found.group(1) or found.group(2) or ""
    for suffix in _SUFFIXES:
        if name.endswith(f"_{suffix}"):
            name, unit = name[: -len(suffix) - 1], suffix
    if name in TIMES:
        return _Column("t", unit=unit)
    if name in FRAMES:
        return _Column("frame")
    if name in OBJECTS:
        return _Column("object")
    if (individual := re.fullmatch(r"([xyz])(\d+)", name)) is not None:
        return _Column(individual.group(1), individual.group(2), unit)
    point, axis = next((name.rsplit(mark, 1) for mark in "_./ " if mark in name), ("", name))
    # What has a unit per second is a velocity, as Tracker exports them.
    is_place = axis in ("x", "y", "z") and "/" not in unit
    return _Column(axis, "" if point == "position" else point, unit) if is_place else None


def _even_rows(rows: Sequence[Sequence[str]], width: int) -> list[list[str]]:
    """Return rows of as many cells."""
    return [[*row, *[""] * width][:width] for row in rows]


def _read_columns(path: Path, rows: list[list[str]], target: str | None) -> TrackTable:
    head, columns, notes = _find_names(path, rows)
    body = _join_commas(path, rows[head + 1 :], len(columns), notes)
    if head > 0 and len({column.point for column in columns if column and column.kind in "xyz"}) == 1:
        columns = _choose_columns(path, rows[head - 1], columns, target)
    names = [column.point for column in columns if column and column.kind in "xyz"]
    by_points = target is not None and any(names) and not any(column and column.kind == "object" for column in columns)
    if all(map(str.isdigit, names)) or by_points:
        chosen = _choose(path, names, target and target.lower())
        columns = [column if column and column.point in ("", chosen) else None for column in columns]
    places: dict[tuple[str, str], int] = {}
    for j, column in enumerate(columns):
        if column is None:
            continue
        key = (column.kind, column.point)
        if key in places and column.kind in "xyz":
            raise InputError(f"{path}: has two columns {column.kind}, as of two objects; keep those of one")
        places.setdefault(key, j)
    units = _find_units(path, columns, body[:4])
    if (j := places.pop(("object", ""), -1)) >= 0:
        named = [
            row for row in body if row[j] and _NUMBER.fullmatch(row[places["x", ""]] if ("x", "") in places else "0")
        ]
        chosen = _choose(path, [row[j] for row in named], target)
        body = [row for row in named if row[j] == chosen] or body
    is_frames = ("t", "") not in places or units["t"] in FRAMES
    cells = ([row[j] for row in body] for j in places.values())
    numbers = dict(zip(places, _read_numbers(path, cells).T, strict=True))
    t = numbers["frame", ""] if is_frames and ("frame", "") in places else numbers["t", ""]
    heads = {cell.lower() for cell in rows[head]} if head >= 0 else set()
    is_image = any(known <= heads for known in PIXEL_PROGRAMS)
    return TrackTable(
        t * (1.0 if is_frames else _find_second(path, units["t"])),
        _gather_points(path, numbers, is_image),
        is_frames=is_frames,
        is_image=is_image,
        unit=units["x"],
        notes=tuple(notes),
    )


def _find_units(path: Path, columns: Sequence["_Column | None"], below: Sequence[Sequence[str]]) -> dict[str, str]:
    """Return the units of times and of coordinates, by ``t`` and ``x``, from names and from the rows below (TrackMate)."""
    found: dict[str, set[str]] = {"t": set(), "x": set()}
    for j, column in enumerate(columns):
        if column is not None and column.kind in "txyz":
            words = [column.unit, *(row[j].strip("()") for row in below if row[j].startswith("("))]
            found["t" if column.kind == "t" else "x"] |= {_PIXELS.get(word, word) for word in words if word} or {""}
    if len(found["x"]) > 1:
        units = ", ".join(unit or "none" for unit in sorted(found["x"]))
        raise InputError(f"{path}: its coordinates have several units: {units}; name one for all")
    return {kind: next(iter(sorted(units)), "") for kind, units in found.items()}


def _find_second(path: Path, unit: str) -> float:
    """Return a unit of times, or a picture of clocks such as hh:mm:ss, in s. Raises InputError if it is not known."""
    if unit and unit not in _SECONDS and ":" not in unit:
        raise InputError(f"{path}: the unit '{unit}' of its times is not known; take {', '.join(_SECONDS)}")
    return _SECONDS.get(unit, 1.0)


def _join_commas(path: Path, rows: Sequence[list[str]], width: int, notes: list[str]) -> list[list[str]]:
    """Return rows of ``width`` cells; where commas separate cells and decimals, both halves of a number are joined."""
    whole = re.compile(r"[+-]?\d+")
    lengths = [len(row) - next((k for k, cell in enumerate(reversed(row)) if cell), len(row)) for row in rows]
    halves = set(lengths) == {2 * width}
    if halves and all(whole.fullmatch(cell) for row in rows for cell in row[: 2 * width]):
        notes.append("commas separate columns and decimals, so each number is taken from two cells")
        return [[".".join(row[k : k + 2]) for k in range(0, 2 * width, 2)] for row in rows]
    if (long := next((k for k, length in enumerate(lengths) if length > width), None)) is not None:
        raise InputError(
            f"{path}: row {long + 1} below the names has {lengths[long]} cells for {width} names: if commas separate decimals too, "
            "export it with semicolons, or with decimal points"
        )
    return _even_rows(rows, width)


def _choose_columns(
    path: Path, above: Sequence[str], columns: list[_Column | None], target: str | None
) -> list[_Column | None]:
    """Return the columns of one object, whose name is above its columns and holds until the next."""
    objects = [""] * len(columns)
    for j, cell in enumerate(above[: len(columns)]):
        objects[j:] = [cell or objects[j - 1]] * len(objects[j:])
    pairs = list(zip(objects, columns, strict=True))
    if len({name for name, column in pairs if column and column.kind in "xyz"}) < 2:
        return columns
    chosen = _choose(path, objects, target)
    return [c if c and (name == chosen or c.kind in ("t", "frame")) else None for name, c in pairs]


def _find_names(path: Path, rows: list[list[str]]) -> tuple[int, list[_Column | None], list[str]]:
    """Return the row of names (-1 without one), what its columns hold, and notes."""
    for k, row in enumerate(rows[:10]):
        columns = [_name_column(cell) for cell in row]
        kinds = {column.kind for column in columns if column is not None}
        if kinds & {"t", "frame"} and kinds & {"x", "y", "z"}:
            return k, columns, []
    width = len(rows[0])
    if 3 <= width <= 4 and all(_NUMBER.fullmatch(cell) for cell in rows[0]):
        names = ("t", "x", "y", "z")[:width]
        return (-1, [_Column(name) for name in names], [f"no row of names: columns are taken as {', '.join(names)}"])
    first = ", ".join(rows[0])[:60]
    raise InputError(f"{path}: no row names its columns: expected t (or frame) with x, y or z, found '{first}'")


def _gather_points(path: Path, columns: dict[tuple[str, str], FloatArray], is_image: bool) -> dict[str, FloatArray]:
    points: dict[str, FloatArray] = {}
    for point in dict.fromkeys(point for kind, point in columns if kind in ("x", "y", "z")):
        given = {kind: columns[kind, point] for kind in "xyz" if (kind, point) in columns}
        nothing = np.full(len(next(iter(given.values()))), np.nan)
        if "y" in given and "z" in given and not is_image:
            points[point] = np.column_stack([given.get("x", nothing), given["y"], given["z"]])
        else:
            # A picture's second coordinate is its height, whether it is called y or z; its z, if any, is that of its plane.
            up = given.get("y", given.get("z", nothing))
            points[point] = np.column_stack([given.get("x", nothing), up])
    if len({values.shape[1] for values in points.values()}) > 1:
        raise InputError(f"{path}: some of its points have three coordinates, and some two")
    return points
