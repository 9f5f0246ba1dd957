"""A track: points of an agent's axis in a film, and their times; its faults and repairs."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import quote

import numpy as np
import numpy.typing as npt

from driftform.errors import InputError, did_you_mean
from driftform.types import Body, FloatArray
from driftform_calibration.tables import TrackTable, read_table

MIN_POINTS = 5
"""Fewest instants of a track: a fall has a start, a speed and an acceleration, and some must be left to check them."""

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Units of length that a track may have, in m."""

MAX_INTERVAL = 2.0
"""Longest time between most frames, s; longer ones are frames or milliseconds that were taken for seconds."""

MIN_JUMP = 0.03
"""Distance beyond that of the neighbours, over the span of a track, that no motion explains."""

SCATTER = 0.05
"""Noise of a track over its span that no camera has."""

CLEAR_JUMPS = 5.0
"""Mean of regular jumps over its standard error from which frames are missing there: some 200 rhythms are tried."""

LIKELY = 0.6
"""Least likelihood of a point, as DeepLabCut states it."""

AXIS_NAMES = {
    "core": "core", "centre": "core", "center": "core", "body": "core", "": "core", "point": "core",
    "fore": "fore", "nose": "fore", "head": "fore", "front": "fore",
    "aft": "aft", "tail": "aft", "rear": "aft", "back": "aft",
}  # fmt: skip
"""What points of the axis are called."""


@dataclass(frozen=True, eq=False)
class Track:
    """One filmed flight.

    Attributes:
        t: times of the frames, s, increasing, (n,).
        points: where markers on the agent's axis were seen, m, NaN where they were not: to the right and up in the
            picture, (markers, n, 2), or in space, (markers, n, 3).
        places: where each marker is on the axis, from the core's centre, m.
        notes: repairs, one line each.
    """

    name: str
    t: FloatArray
    points: FloatArray
    places: tuple[float, ...] = (0.0,)
    notes: tuple[str, ...] = ()

    def cut(self, end: float) -> "Track":
        """Return the track up to the time ``end``, s."""
        return _pick_rows(self, np.flatnonzero(self.t <= end))

    @property
    def is_spatial(self) -> bool:
        """True if its points are in space."""
        return bool(self.points.shape[2] == 3)

    @property
    def span(self) -> float:
        """Greatest extent of its first marker in any direction, m."""
        points = self.points[0]
        seen = ~np.isnan(points).all(axis=0)
        return float(np.max(np.nanmax(points[:, seen], axis=0) - np.nanmin(points[:, seen], axis=0)))


@dataclass(frozen=True)
class Reading:
    """How the numbers of a track are read.

    Attributes:
        unit: of lengths: a key of :data:`UNITS`; ``None`` for what the file says, or m.
        scale: metres per pixel, ``None`` if the coordinates are not pixels.
        fps: frames per second, ``None`` if the file has times.
        y_down: whether y grows downward; ``None`` for downward if the coordinates are pixels.
        target: the tracked object among several, ``None`` for the only one.
        points: where on the axis (m) each named point is, in addition to :data:`AXIS_NAMES`.
    """

    unit: str | None = None
    scale: float | None = None
    fps: float | None = None
    y_down: bool | None = None
    target: str | None = None
    points: Mapping[str, float] | None = None


def read_track(path: Path, body: Body, reading: Reading) -> Track:
    """Read a track; see :mod:`driftform_calibration.tables`.

    Raises InputError if it cannot be read, or is not the track of one flight: one line with the file and the next step.
    """
    table = read_table(path, reading.target)
    scale = _find_scale(path, table, reading)
    markers = _name_markers(path, table, body, reading)
    if table.is_frames and reading.fps is None:
        raise InputError(f"{path}: has frames and no times; give --fps, the frames per second")
    counts = table.is_frames or bool((np.diff(table.t) == 1.0).all())
    t = np.asarray(table.t / reading.fps) if counts and reading.fps else table.t
    t = (
        t - first if (first := np.nanmin(t, initial=np.inf)) > 1e6 else t
    )  # Time stamps have few digits left for the motion.
    down = table.is_image or reading.scale is not None if reading.y_down is None else reading.y_down
    notes = list(table.notes)
    if down and reading.y_down is None:
        notes.append("coordinates are those of a picture, so y is taken to point down (--y-up if it does not)")
    flip = np.array([1.0, -1.0] if down and not table.is_spatial else [1.0] * (3 if table.is_spatial else 2))
    points = {name: scale * flip * table.points[name] for name in markers}
    for name, likely in table.likelihood.items():
        if name in points and (doubtful := likely < LIKELY).any():
            points[name][doubtful] = np.nan
            notes.append(f"{int(doubtful.sum())} points of '{name}' less likely than {LIKELY:g} left out")
    return check_track(
        str(path), Track(path.name, t, np.array(list(points.values())), tuple(markers.values()), tuple(notes))
    )


def check_track(label: str, track: Track) -> Track:
    """Return a track in the order of its times and without empty rows; ``label`` names it in errors.

    Raises InputError if it is too short, does not move, or follows two objects.
    """
    notes = list(track.notes)
    keep = ~np.isnan(track.points).all(axis=(0, 2)) & np.isfinite(track.t)
    if (lost := int((~keep).sum())) and keep.any():
        notes.append(f"{lost} of {len(keep)} rows without a time or a point left out")
    track = _pick_rows(track, np.flatnonzero(keep))
    steps = np.diff(track.t)
    if (steps < 0).any():
        notes.append(f"times go back {int((steps < 0).sum())} times: rows were put in the order of time")
    track = _pick_rows(track, np.argsort(track.t, kind="stable"))
    track = _merge_doubles(label, track, notes)
    if len(track.t) < MIN_POINTS:
        raise InputError(f"{label}: has {len(track.t)} usable points, at least {MIN_POINTS} are needed")
    usual = float(np.median(np.diff(track.t)))
    if usual > MAX_INTERVAL:
        raise InputError(
            f"{label}: its times are {usual:g} apart: give --fps N if they are frames, or their unit, as in t (ms)"
        )
    track = _mend_lost_frames(track, notes)
    _check_jumps(label, track, notes)
    if not track.span > 0:
        raise InputError(f"{label}: its points do not move")
    return replace(track, notes=tuple(notes))


def _find_scale(path: Path, table: TrackTable, reading: Reading) -> float:
    for option, given, fitting in (("scale", reading.scale, "px"), ("unit", reading.unit, reading.unit)):
        if given and table.unit not in ("", fitting):
            raise InputError(f"{path}: its coordinates are in {table.unit}; leave out --{option} {given}")
    if reading.scale is not None:
        return reading.scale
    # Pictures that ImageJ calibrates have lengths.
    unit = table.unit or reading.unit or ("px" if table.is_image else "m")
    if unit == "px":
        raise InputError(f"{path}: its coordinates are pixels; give --scale, the metres per pixel")
    if unit not in UNITS:
        raise InputError(f"{path}: unit '{unit}' is not known{did_you_mean(unit, UNITS)}")
    return UNITS[unit]


def _name_markers(path: Path, table: TrackTable, body: Body, reading: Reading) -> dict[str, float]:
    ends = {"core": 0.0, "fore": float(body.outer[-1, 0]), "aft": float(body.outer[0, 0])}
    given = dict(reading.points or {})
    for name in given:
        if name not in table.points:
            raise InputError(f"--point {name}: {path} has no such point{did_you_mean(name, table.points)}")
    found = {
        name: given[name] if name in given else ends[AXIS_NAMES[name.lower()]]
        for name in table.points
        if name in given or name.lower() in AXIS_NAMES
    }
    if not found and len(table.points) == 1:
        return dict.fromkeys(table.points, 0.0)
    if not found:
        raise InputError(
            f"{path}: has the points {', '.join([*table.points][:9])}{', ...' * (len(table.points) > 9)}; say where on the axis they are, such as --point "
            f"{quote(f'{next(iter(table.points))}=0.01')} (m from the core's centre, fore positive), or choose one with --object"
        )
    return found


def _pick_rows(track: Track, rows: npt.NDArray[np.intp]) -> Track:
    return replace(track, t=track.t[rows], points=track.points[:, rows])


def _merge_doubles(label: str, track: Track, notes: list[str]) -> Track:
    """Return a track with one row for each time; many times with two different rows are two objects."""
    double = np.flatnonzero(np.diff(track.t) <= 0)
    if not len(double):
        return track
    points = track.points[0]
    apart = np.nanmax(np.abs(points[double + 1] - points[double]), axis=1, initial=0.0)
    if (apart > 1e-9).sum() > 0.2 * len(track.t):
        raise InputError(
            f"{label}: has two points at {int((apart > 1e-9).sum())} times, as if it followed two objects; keep one"
        )
    notes.append(f"{len(double)} rows with the time of another left out")
    return _pick_rows(track, np.delete(np.arange(len(track.t)), double + 1))


def has_even_times(track: Track) -> bool:
    """Return whether the times of a track have no gaps: what was lost between its frames, if anything, is not in them."""
    steps = np.diff(track.t)
    return bool(np.ptp(steps) <= 0.1 * np.median(steps))


def _mend_lost_frames(track: Track, notes: list[str]) -> Track:
    """Return a track with the times of frames that were lost in a rhythm and numbered without a gap, if there are such.

    Between the frames next to a lost one the agent moves twice as far as before and after. The steps along the path, over
    their smoothed length (a moving parabola, Savitzky and Golay 1964), are averaged at each phase of each rhythm.
    """
    half, steps = 10, np.diff(track.t)
    points = track.points[0][:, np.isfinite(track.points[0]).all(axis=0)]
    if len(steps) < 4 * half or not points.size or not has_even_times(track):
        return track
    kernel = np.linalg.pinv(np.vander(np.arange(-half, half + 1), 3))[-1]

    def measure(moves: FloatArray) -> tuple[FloatArray, FloatArray]:
        smooth = np.column_stack([np.convolve(column, kernel, "valid") for column in moves.T])
        weight = (smooth**2).sum(axis=1)
        return (moves[half:-half] * smooth).sum(axis=1) / np.maximum(weight, 1e-300) - 1.0, weight

    excess, weight = measure(np.diff(points, axis=0))
    scatter = 1.4826 * float(np.median(np.abs(excess - np.median(excess)) * np.sqrt(weight)))
    best = (0.0, 4, 0, 0.0)
    for period in range(4, min(20, len(excess) // 3) + 1):
        phases = np.arange(half, half + len(excess)) % period
        for phase in range(period):
            jump = _compare(excess, weight, phases == phase)
            clear = jump * np.sqrt(weight[phases == phase].sum()) / max(scatter, 1e-12)
            best = max(best, (float(clear), period, phase, jump))
    clear, period, phase, jump = best
    inside = np.arange(len(steps)) % period == phase
    for lost in (1, 2, 3):
        expected = _compare(*measure(1.0 + lost * inside[:, None]), inside[half:-half])
        # A bounce is one jump: half of the steps at this phase must be as long.
        usual = float(np.median(excess[inside[half:-half]]) - np.median(excess[~inside[half:-half]]))
        if clear > CLEAR_JUMPS and max(abs(jump / expected - 1), abs(usual / expected - 1)) < 0.3:
            notes.append(
                f"after every {period} frames {lost} of them missing, by regular jumps of the points: times were corrected"
            )
            shifts = np.cumsum(inside) * lost * float(np.median(steps))
            return replace(track, t=track.t + np.concatenate([[0.0], shifts]))
    return track


def _compare(values: FloatArray, weight: FloatArray, inside: npt.NDArray[np.bool_]) -> float:
    """Return the weighted mean of some values less that of the others."""
    here, there = (np.average(values[some], weights=weight[some]) for some in (inside, ~inside))
    return float(here - there)


def _check_jumps(label: str, track: Track, notes: list[str]) -> None:
    noise, span = estimate_noise(track), track.span
    if noise > SCATTER * span:
        raise InputError(
            f"{label}: its points scatter by {noise:.2g} m in {span:.2g} m, as if it followed two objects; keep one"
        )
    for seen in track.points:
        known = np.flatnonzero(~np.isnan(seen).all(axis=1))
        points, t = np.nan_to_num(seen[known]), track.t[known]
        if len(t) < 2 * MIN_POINTS:
            continue
        speed = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(t)
        padded = np.pad(speed, 4, constant_values=np.nan)
        around = np.array([np.nanmedian(np.delete(padded[k : k + 9], 4)) for k in range(len(speed))])
        excess = (speed - 3 * around) * np.diff(t)
        jumps = np.flatnonzero(excess > max(8 * noise, MIN_JUMP * span))
        if not len(jumps):
            continue
        first = jumps[0]
        if len(jumps) % 2 == 1 and min(first, len(speed) - 1 - first) >= MIN_POINTS:
            raise InputError(
                f"{label}: jumps {excess[first]:.2g} m between t = {t[first]:.3f} and {t[first + 1]:.3f} s, as if frames were "
                "lost there, or it followed another object from there; give it the times of its frames, or cut it there"
            )
        notes.append(f"{len(jumps)} jumps, the first at t = {t[first]:.3f} s: such points count little")


def estimate_noise(track: Track) -> float:
    """Return the standard deviation of the error of a track's coordinates, m, without any model of the motion.

    Each point is compared with the cubic through two neighbours on each side. The error of a smooth motion is far
    smaller; single points that are far off do not matter (median absolute deviation).
    """
    spreads = []
    for values in np.moveaxis(track.points, 2, 1).reshape(-1, len(track.t)):
        known = np.isfinite(values)
        t, v = track.t[known], values[known]
        if len(t) < 8:
            continue
        offsets = np.column_stack([t[i : len(t) - 4 + i] for i in range(5)])
        nodes, middle = offsets[:, [0, 1, 3, 4]], offsets[:, 2]
        # Lagrange's polynomials of the neighbours, at the point between them.
        others = np.array([np.delete(nodes, j, axis=1) for j in range(4)])
        weights = np.prod((middle[:, None] - others) / (nodes.T[:, :, None] - others), axis=2).T
        seen = np.column_stack([v[i : len(v) - 4 + i] for i in (0, 1, 3, 4)])
        off = (v[2:-2] - (weights * seen).sum(axis=1)) / np.sqrt(1 + (weights**2).sum(axis=1))
        spreads.append(1.4826 * float(np.median(np.abs(off))))
    return max(spreads, default=0.0)
