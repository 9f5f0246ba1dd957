"""The least-squares problem of a calibration: parameters, residuals and their derivatives.

The unknowns are the factors, which all tracks share, and for each track its release and its camera. A derivative by a
factor or by the release takes a flight; those by the camera follow from the flight itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray
from driftform.water import Factors
from driftform_calibration.bench import Bench, Path, ReleaseError
from driftform_calibration.camera import VIEWS, Camera, see_points
from driftform_calibration.tracks import Track

PRIOR = 0.5
"""Standard deviation of the logarithm of a factor before anything was filmed: a third more or less is common, a half rare."""

PRIOR_HULL = 0.1
"""The same of the density of the hull, at least; more if :data:`PRIOR` of the net weight is more."""

LIGHTEST = 0.02
"""Least density of a hull over that of the model."""

TILT = np.deg2rad(5.0)
"""Standard deviation of the turn of a camera, rad."""

RELEASE_ANGLE = float(np.deg2rad(3.0))
"""Standard deviation of pitch and yaw of a release by hand, rad."""

LOOK_DOWN = np.deg2rad(8.0)
"""Most by which a camera looks down or up, rad; any angle up to it is as likely."""

ASPECT = float(np.hypot(0.002, LOOK_DOWN**2 / np.sqrt(45)))
"""Standard deviation of the width of a picture over its height: 4 degrees towards the camera, and its own pitch."""

NARROWER = float(LOOK_DOWN**2 / 6 - 0.5 * RELEASE_ANGLE**2)
"""Its expected logarithm: heights look shorter from above, an agent that moves towards the camera or away looks slower."""

DISTANCE = 2.5
"""Default distance of a camera, m."""

BARREL = 0.01
"""Standard deviation of what a lens bends at the ends of a track: 3 % at the corner of a wide picture that it fills."""

RELEASE_SPEED, RELEASE_RISE = 0.005, 0.005
"""Standard deviations of the speed of a release from rest in each direction, m/s, and of its height above a floor, m."""

MAX_LEAD = 3.0
"""Longest time before the first point at which the release may be, over the duration of the track."""

_STEP = 1e-3
"""Step of a derivative by an unknown of a release, SI."""

_ROUGH = 0.02
"""Step of a derivative by a coefficient of contact: bounces make smaller ones accidental."""


@dataclass(frozen=True, eq=False)
class Filmed:
    """One film: the agent in the scenario of its release, the track, and the view of the camera.

    ``scale_error`` is the standard deviation of the film's scale, relative to it; ``distance`` (m) is that of the camera.
    """

    bench: Bench
    track: Track
    view: str = "side"
    scale_error: float = 0.005
    distance: float = DISTANCE

    def cut(self, end: float) -> "Filmed":
        """Return the film up to the time ``end``, s."""
        return replace(self, track=self.track.cut(end))

    @cached_property
    def axes(self) -> FloatArray:
        """World directions of the track's coordinates, (2, 3) or (3, 3)."""
        return np.eye(3) if self.track.is_spatial else VIEWS[self.view]

    @cached_property
    def times(self) -> FloatArray:
        """Time of each residual: of the coordinates of the points that were seen, s."""
        return np.asarray(self.track.t[np.nonzero(~np.isnan(self.track.points))[1]])

    @cached_property
    def seen_axes(self) -> FloatArray:
        """True for each coordinate that the track has, (d,)."""
        return np.asarray(~np.isnan(self.track.points).all(axis=(0, 1)))


@dataclass(frozen=True)
class Parameter:
    """One unknown: to whom it belongs (number of the track, -1 for a factor), its range, and what is known of it.

    ``prior`` is the standard deviation about ``start``, infinite if nothing is known.
    """

    owner: int
    name: str
    start: float
    low: float
    high: float
    prior: float
    step: float = 0.0


@dataclass(frozen=True, eq=False)
class Anchor:
    """What an earlier fit has shown of parameters: residuals ``rows @ (x - centre)`` of variance 1.

    Attributes:
        keys: owner and name of the parameters, (k,).
        centre: their values, (k,).
        rows: (k, k).
        ends: time of the last point of each track of that fit, s.
    """

    keys: Sequence[tuple[int, str]]
    centre: FloatArray
    rows: FloatArray
    ends: Sequence[float]


class Problem:
    """Residuals in units of the noise, priors after them; :attr:`parameters` are the unknowns, in their order."""

    def __init__(
        self,
        films: Sequence[Filmed],
        names: Sequence[str],
        noise: Sequence[float],
        priors: dict[str, tuple[float, float]] | None = None,
        anchor: "Anchor | None" = None,
    ) -> None:
        self.films, self.names, self.noise = tuple(films), tuple(names), tuple(noise)
        self.known_before, self._anchor = priors, anchor
        self.parameters = [*self._list_factors(priors or {})]
        for number, film in enumerate(films):
            self.parameters += _list_release(number, film) + _list_camera(number, film)
        self.start = np.array([p.start for p in self.parameters])
        self.low = np.array([p.low for p in self.parameters])
        self.high = np.array([p.high for p in self.parameters])
        self.prior_rows, self.prior_centre = self._list_priors()
        self._state = lru_cache(maxsize=8)(self._compute_state)
        self._jacobian = lru_cache(maxsize=2)(self._compute_jacobian)

    def _list_factors(self, priors: dict[str, tuple[float, float]]) -> list[Parameter]:
        found = []
        bench = self.films[0].bench
        for name in self.names:
            if name == "hull_density":
                width = max(PRIOR_HULL, PRIOR * abs(bench.net_weight) / max(bench.hull_weight, 1e-12))
                low, high, start, step = LIGHTEST - 1.0, 50.0, 0.0, 1e-3 * max(1.0, width)
            else:
                width, low, high, start, step = PRIOR, -2.0, 2.0, 0.0, 1e-3
            if name in ("restitution", "friction"):
                step = _ROUGH
            if name == "restitution":
                values = [film.bench.scenario.contact.restitution for film in self.films]
                low = min(-1e-3, float(np.log(0.1 / min(values))))
                high = max(1e-3, float(np.log(1.0 / max(values))))
            if name in priors:
                start, width = priors[name]
            found.append(Parameter(-1, name, start, low, high, width, step))
        return found

    def with_noise(self, noise: Sequence[float]) -> "Problem":
        """Return the same problem with another noise of each track, m."""
        return Problem(self.films, self.names, noise, self.known_before, self._anchor)

    def take_over(self, other: "Problem", x: FloatArray) -> FloatArray:
        """Return the unknowns of another problem as those of this one; what that one does not have has its start."""
        known = {(p.owner, p.name): value for p, value in zip(other.parameters, x, strict=True)}
        return np.array([known.get((p.owner, p.name), p.start) for p in self.parameters])

    def _list_priors(self) -> tuple[FloatArray, FloatArray]:
        """Return what is known before: rows (k, parameters), and the centre (parameters,) from which they measure."""
        places = {(p.owner, p.name): j for j, p in enumerate(self.parameters)}
        known = [] if self._anchor is None else [places[key] for key in self._anchor.keys]
        rows = np.diag([0.0 if j in known else 1 / p.prior for j, p in enumerate(self.parameters)])
        rows, centre = rows[rows.any(axis=1)], self.start.copy()
        if self._anchor is None:
            return rows, centre
        held = np.zeros((len(known), len(self.parameters)))
        held[:, known] = self._anchor.rows
        centre[known] = self._anchor.centre
        return np.vstack([rows, held]), centre

    def factors(self, x: FloatArray) -> Factors:
        """Return the factors of a point of the parameter space."""
        values = {p.name: float(v) for p, v in zip(self.parameters, x, strict=True) if p.owner == -1}
        return Factors(**{name: factor_of(name, value) for name, value in values.items()})

    def release(self, x: FloatArray, number: int) -> ReleaseError:
        """Return the release of a track."""
        v = self._values(x, number)
        axes = self.films[number].axes
        right, up = (axes[0], axes[1]) if len(axes) == 2 else (axes[0], axes[2])
        x_rate, y_rate, z_rate = (v.get("right", 0.0) * right + v.get("up", 0.0) * up).tolist()
        velocity = x_rate, y_rate, z_rate
        return ReleaseError(v.get("pitch", 0.0), v.get("yaw", 0.0), velocity, v.get("rise", 0.0))

    def camera(self, x: FloatArray, number: int) -> Camera:
        """Return the camera of a track."""
        v = self._values(x, number)
        offset = tuple(v.get(f"offset {axis}", 0.0) for axis in range(len(self.films[number].axes)))
        names = ("delay", "scale", "tilt", "aspect", "keystone", "barrel")
        return Camera(offset=offset, **{name: v.get(name, 0.0) for name in names})

    def _values(self, x: FloatArray, number: int) -> dict[str, float]:
        return {p.name: float(v) for p, v in zip(self.parameters, x, strict=True) if p.owner == number}

    def until(self, x: FloatArray, number: int) -> float:
        """Return the time of the last point of a track after its release, s."""
        return float(self.films[number].track.t[-1]) - self.camera(x, number).delay

    def fly(self, x: FloatArray, number: int) -> Path:
        """Return the flight of a track."""
        until = self.until(x, number)
        return self.films[number].bench.fly(self.factors(x), self.release(x, number), until)

    def see(self, x: FloatArray, number: int, path: Path | None = None) -> FloatArray:
        """Return what the film of a track shows: markers (markers, n, d), m."""
        film = self.films[number]
        return see_points(path or self.fly(x, number), film.track, film.axes, self.camera(x, number))

    def residuals(self, x: FloatArray) -> FloatArray:
        """Return differences of model and tracks over the noise, then those of the parameters from their priors."""
        known_before = self.prior_rows @ (x - self.prior_centre)
        return np.concatenate([*(r for _, r in self._state(x.tobytes())), known_before])

    def _compute_state(self, key: bytes) -> list[tuple[Path, FloatArray]]:
        x = np.frombuffer(key)
        paths = [self.fly(x, number) for number in range(len(self.films))]
        return [(path, self._weigh(number, self.see(x, number, path))) for number, path in enumerate(paths)]

    def _weigh(self, number: int, points: FloatArray) -> FloatArray:
        """Return the differences of one track over their noise, of what was seen only."""
        observed = self.films[number].track.points
        return np.asarray((points - observed)[~np.isnan(observed)] / self.noise[number])

    def list_new(self, number: int) -> npt.NDArray[np.bool_]:
        """Return which residuals of a track the earlier fit has not counted, (residuals,)."""
        end = -np.inf if self._anchor is None else self._anchor.ends[number]
        return np.asarray(self.films[number].times > end)

    @cached_property
    def counts(self) -> list[int]:
        """Number of residuals of each track."""
        return [int((~np.isnan(film.track.points)).sum()) for film in self.films]

    def distances(self, x: FloatArray) -> list[FloatArray]:
        """Return the distances (m) of the markers from where the model has them, of each track, (markers, n)."""
        found = []
        for number, film in enumerate(self.films):
            off = self.see(x, number, self._state(x.tobytes())[number][0]) - film.track.points
            found.append(np.where(np.isnan(off).all(axis=2), np.nan, np.sqrt(np.nansum(off**2, axis=2))))
        return found

    def paths(self, x: FloatArray) -> list[Path]:
        """Return the flights of all tracks."""
        return [path for path, _ in self._state(x.tobytes())]

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Return the derivatives of :meth:`residuals`, (residuals, parameters)."""
        return self._jacobian(x.tobytes())

    def _compute_jacobian(self, key: bytes) -> FloatArray:
        x = np.frombuffer(key)
        data = [self._derive(x, number, path) for number, (path, _) in enumerate(self._state(key))]
        return np.vstack([*data, self.prior_rows])

    def _derive(self, x: FloatArray, number: int, path: Path) -> FloatArray:
        base = self._weigh(number, self.see(x, number, path))
        out = np.zeros((len(base), len(self.parameters)))
        for j, p in enumerate(self.parameters):
            if p.owner not in (-1, number):
                continue
            # The camera's have no step: the flight is the same, and its end, which follows the delay, is not seen.
            step, flown = (p.step, None) if p.step else (1e-5, path)
            if p.step and x[j] + step > p.high:
                step = -step
            if p.name == "rise" and np.isinf(path.contact):
                # In still water a whole flight without a contact rises with its release, but for rounding.
                flown = replace(path, position=path.position + np.array([0.0, 0.0, step]))
            moved = x.copy()
            moved[j] += step
            out[:, j] = (self._weigh(number, self.see(moved, number, flown)) - base) / step
        return out


def shown_name(name: str) -> str:
    """Return the name of a factor as tables show it: the density of the hull shows as the net weight that it changes."""
    return "net_weight" if name == "hull_density" else name


def factor_of(name: str, value: float) -> float:
    """Return the factor of a parameter: the hull's density is 1 + value, the others are exp(value)."""
    return 1.0 + value if name == "hull_density" else float(np.exp(value))


def parameter_of(name: str, factor: float) -> float:
    """Return the parameter of a factor, the inverse of :func:`factor_of`."""
    return factor - 1.0 if name == "hull_density" else float(np.log(factor))


def _list_release(number: int, film: Filmed) -> list[Parameter]:
    # A rise shows at a contact only, but until then it is a part of what the place of the camera seems to be.
    widths = {"pitch": RELEASE_ANGLE, "up": RELEASE_SPEED, "rise": RELEASE_RISE}
    # A film of the height alone shows nothing of a drift.
    if film.seen_axes.all():
        widths["right"] = RELEASE_SPEED
        # Seen from the side, a small turn about the vertical hardly shortens what is seen.
        if film.view == "top" or film.track.is_spatial or film.bench.scenario.release.yaw_deg:
            widths["yaw"] = RELEASE_ANGLE
    return [Parameter(number, name, 0.0, -6 * width, 6 * width, width, _STEP) for name, width in widths.items()]


def _list_camera(number: int, film: Filmed) -> list[Parameter]:
    t = film.track.t
    last = float(t[-1] - t[0])
    found = [Parameter(number, "delay", float(t[0]), float(t[0]) - MAX_LEAD * last, float(t[-1]), np.inf)]
    width, start = film.scale_error, 0.0
    if not film.seen_axes.all():
        # One coordinate of a turned camera looks shorter by the cosine: mean and deviation of its logarithm.
        width, start = float(np.hypot(width, TILT**2 / np.sqrt(2))), float(-0.5 * TILT**2)
    if width > 0:
        found.append(Parameter(number, "scale", start, start - 6 * width, start + 6 * width, width))
    if len(film.axes) == 2 and film.seen_axes.all():
        found.append(Parameter(number, "tilt", 0.0, -6 * TILT, 6 * TILT, float(TILT)))
        found.append(Parameter(number, "aspect", NARROWER, -6 * ASPECT, 6 * ASPECT, ASPECT))
    if len(film.axes) == 2:
        width = float(LOOK_DOWN / np.sqrt(3) / film.distance)
        found.append(Parameter(number, "keystone", 0.0, -3 * width, 3 * width, width))
        found.append(Parameter(number, "barrel", 0.0, -6 * BARREL, 6 * BARREL, BARREL))
    found += [
        Parameter(number, f"offset {axis}", 0.0, -np.inf, np.inf, np.inf) for axis in np.flatnonzero(film.seen_axes)
    ]
    return found
