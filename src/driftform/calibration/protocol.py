"""A plan of drops as documents: JSON, study files for each drop, and one page to take to the tank."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from driftform.calibration.experiment import Drop, Plan, Tank, describe_plan
from driftform.figures.drops import DropPicture, drop_svg, ruler_svg
from driftform.figures.section import section_svg
from driftform.types import Agent
from driftform.util.files import make_directory, write_text
from driftform.util.notebook import show_table

TABLES = ("pipe", "flow", "fluid", "release", "contact", "flight", "robustness")
"""Tables of a drop's study file; its plugins are those of the study that it was planned in."""

DISTANCE = 8.0
"""Distance of the camera over the length of the tank's picture: nearer, perspective bends the paths."""

_STYLE = """
body { font: 14px/1.45 system-ui, sans-serif; max-width: 820px; margin: 1.5em auto; padding: 0 1em; color: #1f2a36 }
h1 { font-size: 1.5em; margin: 0 } h2 { font-size: 1.1em; margin: 1.2em 0 .3em }
table { border-collapse: collapse; margin: .5em 0 } th, td { padding: .2em .9em .2em 0; text-align: left }
th { border-bottom: 1px solid #586673 } .drops { display: flex; flex-wrap: wrap; gap: 12px }
.blank { border-bottom: 1px solid #586673; min-width: 6em; display: inline-block }
svg { max-width: 100% } .ruler svg { max-width: none } code { background: #f1f7fb }
@media print { body { margin: 0; font-size: 11px } }
"""


@dataclass(frozen=True, eq=False, repr=False)
class DropPlan:
    """Drops to film for an agent.

    Attributes
    ----------
    name
        of the agent.
    agent
        as simulated, in the water of the tank, without ballast.
    tank
        in which it is dropped.
    plan
        the drops, and what they are expected to show.
    document_base
        the study that it was planned in: its plugins fly the drops.
    """

    name: str
    agent: Agent
    tank: Tank
    plan: Plan
    document_base: Mapping[str, Any]

    @property
    def drops(self) -> tuple[Drop, ...]:
        """The drops, those that tell most first."""
        return self.plan.drops

    def document(self, files: Sequence[Path] = ()) -> dict[str, Any]:
        """Return what ``driftform drop --json`` prints; SI units."""
        return {
            "agent": self.name,
            "mass": self.agent.mass.mass,
            "tank": [self.tank.length, self.tank.width, self.tank.depth],
            "drops": describe_plan(self.plan),
            "expected": {
                name: {"half_width": half, "known": known} for name, (half, known) in self._expected().items()
            },
            "reasons": {_rename(name): reason for name, reason in self.plan.reasons.items()},
            "files": [str(path) for path in files],
        }

    def _expected(self) -> dict[str, tuple[float, bool]]:
        """Half intervals and whether they will do; that of the hull's density as one of the net weight."""
        return {
            _rename(name): (half * self.plan.hull_share if name == "hull_density" else half, known)
            for name, (half, known) in self.plan.expected.items()
        }

    def write(self, directory: Path) -> list[Path]:
        """Write the page and a study file for each drop, and return their paths."""
        import tomli_w

        make_directory(directory)
        paths = [directory / "protocol.html"]
        for number, drop in enumerate(self.drops, start=1):
            dumped = drop.scenario.model_dump(mode="json", exclude_none=True)
            kept = {key: value for key, value in self.document_base.items() if key not in (*dumped, "run")}
            study = {
                **kept,
                "title": f"Drop {number} of {self.name}",
                **{key: dumped[key] for key in TABLES},
            }
            path = directory / f"drop-{number}.toml"
            write_text(path, tomli_w.dumps(study))
            paths.append(path)
        write_text(paths[0], self.html())
        return paths

    def html(self) -> str:
        """Return the page to take to the tank, complete in itself."""
        mass = 1000 * self.agent.mass.mass
        rows = [
            (
                str(number),
                f"{drop.pitch_deg:+.0f} deg ({_describe_attitude(drop.pitch_deg)})",
                f"{1000 * drop.depth:.0f} mm",
                f"{1000 * drop.ballast:.1f} g" if drop.ballast else "none",
                f"{drop.duration:.2f} s, to the {drop.end}",
                f"{drop.gain:.1f} bits",
            )
            for number, drop in enumerate(self.drops, start=1)
        ]
        heads = ("drop", "pitch", "core below the surface", "ballast", "film", "tells")
        ballasts = any(drop.ballast for drop in self.drops)
        expected = [
            (name.replace("_", " "), f"{100 * half:.0f} %", "yes" if known else "no, it stays at 1")
            for name, (half, known) in self._expected().items()
        ]
        expected += [
            (_rename(n).replace("_", " "), "-", f"no: {why}") for n, why in self.plan.reasons.items()
        ]
        size = self.tank
        steps = [
            f"Weigh the print with its core: simulated {mass:.2f} g, measured <span class=blank></span> g. "
            "Dry it first, and look for bubbles in the water.",
            f"Fill the tank {1000 * size.depth:.0f} mm deep. Water: {self.drops[0].scenario.fluid.density:.1f} kg/m3 in the "
            "plan; measured temperature <span class=blank></span>. Let it come to rest for some minutes before each drop.",
            "Print the ruler below at 100 %, and hang it upright where the agent will fall, not on the glass. "
            "Film it before the first drop, and measure its pixels: metres of a pixel are the --scale of calibrate.",
            f"Place the camera level, at half the depth, at least {DISTANCE * size.length:.1f} m away "
            "(zoom in), so that perspective does not bend the paths. Fix focus and exposure; a short exposure; all frames.",
            "Hold the agent at rest in the attitude of the drop, its axis in the plane of the picture, and let go without a "
            "push: a thread that is cut, or tongs that open. The film may begin before.",
        ]
        if ballasts:
            steps.append(
                "Ballast: a sinker of lead on a strip of tape around the core's equator. Weigh it with its tape: "
                "<span class=blank></span> g, and write that into <code>ballast</code> (kg) of the drop's study file."
            )
        steps.append(
            "Track the core's place on the hull (the orange dot), not the middle of the silhouette; cut the track where the "
            "agent breaks the surface or leaves the picture."
        )
        tracks = " ".join(f"drop-{n}.csv" for n in range(1, len(self.drops) + 1))
        pictures = "".join(
            drop_svg(self._picture(number, drop), self.agent.body, size.length, size.depth)
            for number, drop in enumerate(self.drops, start=1)
        )
        return (
            f"<!doctype html><html lang=en><meta charset=utf-8><title>Drops of {escape(self.name)}</title>"
            f"<style>{_STYLE}</style><h1>Drops of {escape(self.name)}</h1>"
            f"<p>Tank {1000 * size.length:.0f} x {1000 * size.width:.0f} mm, water {1000 * size.depth:.0f} mm deep.</p>"
            f"<h2>Releases</h2>{show_table(heads, rows)}<div class=drops>{pictures}</div>"
            f"<h2>What to do</h2><ol>{''.join(f'<li>{step}</li>' for step in steps)}</ol>"
            f"<p>Save the tracks beside the study files as <code>{tracks}</code>, then:</p>"
            f"<p><code>driftform calibrate AGENT {tracks} --printed-mass KG</code></p>"
            f"<h2>What the films are expected to show</h2>"
            f"{show_table(('factor', 'half of the 90 % interval', 'known'), expected)}"
            f"<h2>Ruler</h2><div class=ruler>{ruler_svg()}</div>"
            f"<h2>The agent</h2>{section_svg(self.agent, self.name)}</html>\n"
        )

    def _picture(self, number: int, drop: Drop) -> DropPicture:
        caption = f"pitch {drop.pitch_deg:+.0f} deg" + (
            f", {1000 * drop.ballast:.1f} g of ballast" if drop.ballast else ""
        )
        return DropPicture(f"Drop {number}", caption, drop.scenario.release_quaternion(), drop.path)

    def __repr__(self) -> str:
        return f"<DropPlan of {self.name}: {len(self.drops)} drops>"

    def _repr_html_(self) -> str:
        rows = [
            (
                str(n),
                f"{d.pitch_deg:+.0f}",
                f"{1000 * d.depth:.0f}",
                f"{1000 * d.ballast:.1f}",
                f"{d.gain:.1f}",
            )
            for n, d in enumerate(self.drops, start=1)
        ]
        return show_table(("drop", "pitch deg", "depth mm", "ballast g", "bits"), rows, repr(self)[1:-1])


def _rename(name: str) -> str:
    return "net_weight" if name == "hull_density" else name


def _describe_attitude(pitch_deg: float) -> str:
    if pitch_deg == 0:
        return "level"
    return f"fore end {'down' if pitch_deg > 0 else 'up'}"


def default_directory(name: str) -> Path:
    """Return where the files of a plan go if nobody says."""
    return Path("drops") / name
