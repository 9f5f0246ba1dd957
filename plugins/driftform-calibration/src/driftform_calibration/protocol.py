"""A plan of drops as documents: JSON, study files for each drop, and one page to take to the tank."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from driftform.figures import section_svg, svg
from driftform.types import Agent, FloatArray
from driftform.util import files, notebook
from driftform.water import Scenario
from driftform_calibration.figures import drop_svg, ruler_svg
from driftform_calibration.problem import shown_name

CAMERA = 8.0
"""Distance of the camera over the length of the tank's picture: nearer, perspective bends the paths."""

TABLES = ("pipe", "flow", "gusts", "fluid", "release", "contact", "flight", "robustness")
"""Tables of a drop's study file; its plugins are those of the study that it was planned in."""


@dataclass(frozen=True)
class Tank:
    """Inside of a tank: ``length`` (to the right in the film), ``width`` (towards the camera) and ``depth`` of the water, m."""

    length: float
    width: float
    depth: float


@dataclass(frozen=True, eq=False)
class Drop:
    """One release to film.

    Attributes:
        scenario: whose release it is; the surface is at z = 0.
        duration: from the release to the end of what is filmed, s.
        end: where the agent is then: ``"floor"``, ``"surface"``, ``"side"`` or ``"time"``.
        gain: bits that it adds about the factors, after the drops before it.
        path: expected path in the picture, to the right of the release and above the surface, m, (k, 2).
    """

    scenario: Scenario
    duration: float
    end: str
    gain: float
    path: FloatArray

    def document(self) -> dict[str, Any]:
        """Return the drop as ``driftform drop --json`` prints it; SI units, degrees where the name says so."""
        release = {name: getattr(self.scenario.release, name) for name in ("pitch_deg", "ballast", "ballast_x")}
        depth = -self.scenario.release.position[2]
        return {**release, "depth": depth, "duration": self.duration, "end": self.end, "gain_bits": self.gain}


@dataclass(frozen=True, eq=False, repr=False)
class DropPlan:
    """Drops to film for an agent.

    Attributes:
        agent: as simulated, in the water of the tank, without ballast.
        document_base: the study that it was planned in: its plugins fly the drops.
        drops: in the order of their gain.
        expected: for each factor half of its 90 % interval, relative to the factor, and whether it will count as known.
        reasons: why some factors cannot be shown at all.
        hull_share: weight of the hull over the net weight.
    """

    name: str
    agent: Agent
    tank: Tank
    document_base: Mapping[str, Any]
    drops: tuple[Drop, ...]
    expected: Mapping[str, tuple[float, bool]]
    reasons: Mapping[str, str]
    hull_share: float

    def document(self, files: Sequence[Path] = ()) -> dict[str, Any]:
        """Return what ``driftform drop --json`` prints; SI units."""
        return {
            "agent": self.name,
            "mass": self.agent.mass.mass,
            "tank": [self.tank.length, self.tank.width, self.tank.depth],
            "drops": [drop.document() for drop in self.drops],
            "expected": {
                name: {"half_width": half, "known": known} for name, (half, known) in self._expected().items()
            },
            "reasons": {shown_name(name): reason for name, reason in self.reasons.items()},
            "files": [str(path) for path in files],
        }

    def _expected(self) -> dict[str, tuple[float, bool]]:
        """Half intervals and whether they will do; that of the hull's density as one of the net weight."""
        return {
            shown_name(name): (half * self.hull_share if name == "hull_density" else half, known)
            for name, (half, known) in self.expected.items()
        }

    def tabulate(self) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
        """Return the drops as a table to print: its header and its rows."""
        rows = []
        for number, drop in enumerate(self.drops, start=1):
            release, pitch = drop.scenario.release, drop.scenario.release.pitch_deg
            attitude = "level" if pitch == 0 else f"fore end {'down' if pitch > 0 else 'up'}"
            place = f"{-1000 * release.position[2]:.0f}", f"{1000 * release.ballast:.1f}"
            rows.append(
                (f"{number}", f"{pitch:+.0f}", attitude, *place, f"{drop.duration:.2f}", drop.end, f"{drop.gain:.1f}")
            )
        heads = "drop", "pitch deg", "attitude", "core below surface mm", "ballast g", "film s", "ends at", "bits"
        return heads, rows

    def tabulate_expected(self) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
        """Return what the films are expected to show as a table to print: its header and its rows."""
        rows = []
        for name, (half, known) in self._expected().items():
            unknown = "only if the print is weighed" if name == "net_weight" else "no, it stays at 1"
            rows.append((name.replace("_", " "), f"{100 * half:.0f} %", "yes" if known else unknown))
        rows += [(shown_name(n).replace("_", " "), "-", f"no: {why}") for n, why in self.reasons.items()]
        return ("factor", "half of the 90 % interval", "known"), rows

    def write(self, directory: Path) -> list[Path]:
        """Write the page and a study file for each drop, and return their paths."""
        import tomli_w

        files.make_directory(directory)
        paths = [directory / "protocol.html"]
        for number, drop in enumerate(self.drops, start=1):
            dumped = drop.scenario.model_dump(mode="json", exclude_none=True)
            kept = {key: value for key, value in self.document_base.items() if key not in (*dumped, "run")}
            study = {**kept, "title": f"Drop {number} of {self.name}", **{key: dumped[key] for key in TABLES}}
            path = directory / f"drop-{number}.toml"
            files.write_text(path, tomli_w.dumps(study))
            paths.append(path)
        files.write_text(paths[0], self.html())
        return paths

    def html(self) -> str:
        """Return the page to take to the tank, complete in itself."""
        pictures = [self._draw(number, drop) for number, drop in enumerate(self.drops, start=1)]
        return svg.fill_template(
            __package__,
            "protocol.html",
            title=f"Drops of {self.name}",
            tank=self.tank,
            mass=1000 * self.agent.mass.mass,
            density=self.drops[0].scenario.fluid.density,
            distance=CAMERA * self.tank.length,
            ballasts=any(drop.scenario.release.ballast for drop in self.drops),
            releases=notebook.show_table(*self.tabulate()),
            pictures="".join(pictures),
            tracks=" ".join(f"drop-{n}.csv" for n in range(1, len(self.drops) + 1)),
            expected=notebook.show_table(*self.tabulate_expected()),
            ruler=ruler_svg(),
            section=section_svg(self.agent, self.name),
        )

    def _draw(self, number: int, drop: Drop) -> str:
        release, size = drop.scenario.release, (self.tank.length, self.tank.depth)
        ballast = f", {1000 * release.ballast:.1f} g of ballast" if release.ballast else ""
        caption = f"pitch {release.pitch_deg:+.0f} deg{ballast}"
        return drop_svg(f"Drop {number}", caption, self.agent.body, drop.scenario.release_quaternion(), drop.path, size)

    def __repr__(self) -> str:
        return f"<DropPlan of {self.name}: {len(self.drops)} drops>"

    def _repr_html_(self) -> str:
        return notebook.show_table(*self.tabulate(), repr(self)[1:-1])
