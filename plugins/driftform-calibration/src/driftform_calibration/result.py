"""What a calibration found: as a document, as files, as pictures, and in a notebook."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from driftform import StoredAgent
from driftform.figures import files as picture_files
from driftform.figures import style, svg
from driftform.types import FloatArray
from driftform.util import files, notebook
from driftform_calibration.camera import see_points
from driftform_calibration.figures import TrackPanel, tracks_svg
from driftform_calibration.fit import FactorEstimate, Fit, measure_distance

SHOWN = ("axial_drag", "cross_drag", "added_mass", "net_weight", "restitution", "friction")
"""The factors as tables show them: the density of the hull shows as the net weight that it changes."""

STATIONS = 300
"""Points of a path that is drawn."""

FILES = ("calibration.toml", "agent.json", "report.html", "tracks.svg")


@dataclass(frozen=True, eq=False, repr=False)
class CalibrationResult:
    """Factors on the model of an agent, fitted to films of its flights.

    Attributes:
        fit: values and intervals, and the problem that was solved.
        stored: the agent as it was opened.
        scenarios: in which each track was flown, by name.
    """

    name: str
    fit: Fit
    stored: StoredAgent
    scenarios: Sequence[str]

    @property
    def factors(self) -> Mapping[str, FactorEstimate]:
        """What the films show of each factor: value, low, high, known, and why not."""
        found = {**self.fit.estimates, "net_weight": self.fit.net_weight}
        return {name: found[name] for name in SHOWN}

    @property
    def residual(self) -> float:
        """Root mean square distance of the films from the calibrated flights, m."""
        return self.fit.residual

    @property
    def notes(self) -> tuple[str, ...]:
        """Repairs of the tracks and findings of the fit, one line each."""
        read = [f"{film.track.name}: {note}" for film in self.fit.problem.films for note in film.track.notes]
        return (*read, *self.fit.notes)

    def table(self) -> dict[str, Any]:
        """Return the table ``[calibration]`` in types of TOML."""
        dumped = self.fit.calibration(self.name).model_dump(mode="json", exclude_none=True)
        return {key: value for key, value in dumped.items() if value not in ("", [])}

    def toml(self) -> str:
        """Return the table ``[calibration]`` as text, with one line for each factor."""
        # JSON of numbers, texts and lists of these is TOML too.
        rows = [f"{key} = {json.dumps(value)}" for key, value in self.table().items()]
        return "\n".join(["# For any study: driftform evolve STUDY --calibration FILE", "[calibration]", *rows, ""])

    def tabulate(self) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
        """Return the factors as a table to print: its header and its rows."""
        rows = []
        for name, found in self.factors.items():
            shown = ("1", "not known", found.reason)
            if found.low is not None and found.high is not None:
                shown = (f"{found.value:.3g}", f"{found.low:.3g} to {found.high:.3g}", "")
            rows.append((name.replace("_", " "), *shown))
        return ("factor", "value", "90 % interval", ""), rows

    def document(self) -> dict[str, Any]:
        """Return what ``driftform calibrate --json`` prints; SI units."""
        problem = self.fit.problem
        after, before = problem.distances(self.fit.x), problem.distances(self.fit.x_before)
        return {
            "agent": self.name,
            "factors": {name: _state(estimate) for name, estimate in self.factors.items()},
            "hull_density": _state(self.fit.estimates["hull_density"]),
            "residual": self.fit.residual,
            "residual_before": self.fit.before,
            "tracks": [
                {
                    "track": film.track.name,
                    "scenario": scenario,
                    "points": len(film.track.t),
                    "duration": float(film.track.t[-1] - film.track.t[0]),
                    "span": film.track.span,
                    "noise": noise,
                    "release": float(problem.camera(self.fit.x, number).delay),
                    "residual": measure_distance(after[number : number + 1]),
                    "residual_before": measure_distance(before[number : number + 1]),
                }
                for number, (film, noise, scenario) in enumerate(
                    zip(problem.films, problem.noise, self.scenarios, strict=True)
                )
            ],
            "calibration": self.table(),
            "notes": list(self.notes),
        }

    def calibrated(self) -> StoredAgent:
        """Return the agent with the calibration in its environment; what its run found does not hold any more."""
        environment = {**self.stored.environment, "calibration": self.table()}
        return replace(self.stored, environment=environment, result={})

    def write(self, directory: Path, page: style.Page = style.SCREEN) -> list[Path]:
        """Write table, agent, page and picture into a directory, and return their paths."""
        files.make_directory(directory)
        paths = [directory / name for name in FILES]
        files.write_text(paths[0], self.toml())
        self.calibrated().write(paths[1])
        files.write_text(paths[2], self.html())
        return [*paths[:3], *picture_files.write_picture(paths[3], self.tracks_svg(page), page, png=False)]

    def html(self) -> str:
        """Return a page with the factors, the films against the flights, and the findings of the fit."""
        return svg.fill_template(
            __package__,
            "result.html",
            title=f"Calibration of {self.name}",
            before=self.fit.before,
            after=self.residual,
            factors=notebook.show_table(*self.tabulate()),
            films=self.tracks_svg(),
            notes=self.notes,
            toml=self.toml(),
        )

    def tracks_svg(self, page: style.Page = style.SCREEN) -> str:
        """Return the films against the model before and after calibration, as SVG."""
        problem, fit = self.fit.problem, self.fit
        panels = []
        distances = zip(problem.distances(fit.x_before), problem.distances(fit.x), strict=True)
        for number, (before, after) in enumerate(distances):
            track = problem.films[number].track
            delay = problem.camera(fit.x, number).delay
            t = np.linspace(track.t[0], track.t[-1], STATIONS)
            seen, off = _flatten(track.points[0]), (before[0], after[0])
            paths = (self._trace_path(fit.x_before, number, t), self._trace_path(fit.x, number, t))
            panels.append(TrackPanel(track.name, track.t - delay, seen, t - delay, *paths, *off))
        before_after = f"{1000 * fit.before:.1f} mm before, {1000 * fit.residual:.1f} mm after"
        found = f"root mean square distance {before_after}"
        return tracks_svg(panels, f"{self.name}: films and flights", found, page)

    def _trace_path(self, x: FloatArray, number: int, t: FloatArray) -> FloatArray:
        """Return the path of the first marker in the picture at times ``t`` (s, (k,)) of the film, m, (k, 2)."""
        problem = self.fit.problem
        film, camera = problem.films[number], problem.camera(x, number)
        return _flatten(see_points(problem.fly(x, number), replace(film.track, t=t), film.axes, camera)[0])

    def __repr__(self) -> str:
        known = ", ".join(f"{name} {e.value:.3g}" for name, e in self.factors.items() if e.known)
        return f"<Calibration of {self.name}: {known or 'nothing is known'}; residual {1000 * self.residual:.1f} mm>"

    def _repr_html_(self) -> str:
        return notebook.show_picture(self.tracks_svg(), repr(self)) + notebook.show_table(*self.tabulate())


def _state(found: FactorEstimate) -> dict[str, Any]:
    stated = {"value": found.value, "low": found.low, "high": found.high, "known": found.known}
    return stated if found.known else {**stated, "reason": found.reason}


def _flatten(points: FloatArray) -> FloatArray:
    """Return points of a picture, (n, 2); of points in space their x and z."""
    return points[:, [0, 2]] if points.shape[1] == 3 else points
