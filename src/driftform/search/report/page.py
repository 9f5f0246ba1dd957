"""Contents -> one HTML page.

The page is the template ``page.html``, with ``page.css`` and ``viewer.js`` placed in it. Jinja2 fills it rather than
:class:`string.Template`, because it escapes every value that is not marked ``safe``: names come from the files of
other people, and no line of Python has to remember to escape one. It is imported only when a page is made.
"""

from collections import Counter
from functools import partial
from importlib.resources import files
from math import isfinite
from pathlib import Path
from typing import Any

from driftform.agent import hull_mass
from driftform.figures import scene, style
from driftform.figures.files import write_picture
from driftform.figures.flight import flight_svg
from driftform.figures.section import section_svg
from driftform.motion.forces.limits import list_limits
from driftform.plugins.genome_text import write_genome
from driftform.runs.run import StoredRun
from driftform.runs.wording import (
    describe_doubt,
    describe_worth,
    explain_columns,
    is_promised,
    list_cells,
    list_headings,
    summarise,
)
from driftform.search.report.contents import Contents, collect_contents
from driftform.search.report.kinds import name_kind
from driftform.study import SELECTED
from driftform.util.files import make_directory, write_text
from driftform.water.regime import warn_of_regime

STYLES = {"kept": "good", "kept if weighed": "fair", "reached": "good", "near": "fair", "missed": "poor"}
"""The style class of each verdict."""

BODIES, PROMISE = ("as printed", "weighed in water", "baseline"), ("hits (%)", "90 % miss (mm)")
"""Titles of the groups of columns of a promise, and the headings in each."""


def write_report(run: StoredRun, path: Path | None = None) -> tuple[Contents, Path]:
    """Write the page of a run, by default ``report.html`` in it; return what it holds, and its path.

    Raises InputError if the run is damaged. Raises WorkFailedError if no evaluation succeeded yet.
    """
    contents = collect_contents(run)
    path = path or run.path / "report.html"
    make_directory(path.parent)
    write_text(path, page_html(contents))
    return contents, path


def write_figures(run: StoredRun, folder: Path | None, page: style.Page) -> tuple[Path, ...]:
    """Write the pictures of a run as figures of a paper, by default into its ``figures/paper``, and return their paths."""
    contents = collect_contents(run, page)
    folder = make_directory(folder or run.path / "figures" / "paper", "--out")
    drawn = {name.lower().replace(" ", "-"): picture for name, picture in contents.figures.items()}
    drawn |= {f"causes-{target}": picture for target, picture in contents.causes.items()}
    for [entry, *_] in contents.agents:
        drawn[f"section-{entry.target}"] = section_svg(entry.agent, entry.target, contents.study.scenario, page)
        body = entry.agent.body
        drawn[f"flight-{entry.target}"] = flight_svg(
            entry.trajectory, contents.study.scenario, entry.target, body, page
        )
    return tuple(
        path for name, picture in drawn.items() for path in write_picture(folder / f"{name}.svg", picture, page)
    )


def page_html(contents: Contents) -> str:
    """Return the page: a summary, the best agents, a viewer, and pictures. It loads nothing over the network."""
    import tomli_w
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.tests["finite"] = isfinite
    environment.filters["genome"] = partial(write_genome, contents.study.make_plugin("grammar"))
    environment.filters |= {"fixed": "{:.{}f}".format, "general": "{:g}".format, "metres": _format_length}
    # The viewer reads tens of thousands of numbers; spaces between them would make the page larger.
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    seconds, study, fitness = contents.seconds, contents.study.document, contents.study.make_plugin("fitness")
    results = {entry.target: entry.stored.result for entry in contents.entries}
    promised = all(map(is_promised, results.values()))
    headings = list_headings(fitness, promised)
    # A hit rate and a miss for each of three bodies, if there are as many, under their titles.
    groups = [("", headings)]
    if len(headings) > len(BODIES):
        groups = [("", headings[:1]), *((body, PROMISE) for body in BODIES)]
    kinds = {e.target: name_kind(e.agent, e.trajectory, contents.study.scenario, e.t) for e in contents.entries}
    return environment.from_string(_read("page.html")).render(
        contents=contents,
        title=str(study.get("title", "")) or contents.name,
        style=_read("page.css"),
        script=scene.read_viewer(),
        data=viewer_data(contents),
        lead=summarise(fitness, results) + ".",
        notes=[text for text in (*describe_worth(fitness, results), describe_doubt(fitness, results)) if text],
        kinds=kinds,
        kinds_in_words=", ".join(f"{count} x {kind}" for kind, count in Counter(kinds.values()).most_common()),
        legend=explain_columns(fitness, contents.study.scenario.robustness.checks),
        fitness=fitness,
        numbers={
            "flights": f"{contents.evaluations}",
            "failed": f"{contents.failed}",
            "computing time": f"{seconds:.0f} s" if seconds < 600 else f"{seconds / 60:.0f} min",
            "rate per processor": f"{contents.evaluations / seconds if seconds else 0.0:.3g} flights/s",
            "strategy": str(study.get("strategy", {}).get("use", "")),
            "seed": f"{contents.study.seed}",
        },
        promised=promised,
        groups=groups,
        labels=[", ".join(filter(None, (title, heading))) for title, part in groups for heading in part],
        cells={name: list_cells(fitness, result, promised) for name, result in results.items()},
        verdicts={name: result["verdict"] for name, result in results.items()},
        styles={name: STYLES[result["verdict"]] for name, result in results.items()},
        plugins={seam: study[seam]["use"] for seam in SELECTED if seam in study},
        study=tomli_w.dumps(dict(study)),
        sections=[
            section_svg(group[0].agent, ", ".join(entry.target for entry in group), contents.study.scenario)
            for group in contents.agents
        ],
        limits=[
            *(("every target", line) for line in warn_of_regime(contents.study.scenario)),
            *(
                (", ".join(entry.target for entry in group), line)
                for group in contents.agents
                for line in list_limits(group[0].agent, contents.study.scenario)
            ),
        ],
        hull_mass=hull_mass,
    )


def viewer_data(contents: Contents) -> dict[str, Any]:
    """Return the data of the page's viewer: agents, flights, pipe and targets; SI units, rounded to what is visible."""
    around = scene.scene_data(contents.study.scenario, [entry.trajectory.position for entry in contents.entries])
    longest = max(entry.agent.body.length for entry in contents.entries)
    return {
        "agents": [
            {
                "targets": [entry.target for entry in group],
                **scene.agent_data(
                    group[0].agent,
                    group[0].trajectory,
                    [entry.t for entry in group],
                    style.SERIES[i % len(style.SERIES)],
                ),
            }
            for i, group in enumerate(contents.agents)
        ],
        **around,
        "longest": round(longest, 4),
        # Agents are many times smaller than their pipe, so the longest is drawn as long as its radius.
        "magnification": max(1.0, round(around["size"] / longest, 1)),
    }


def _read(name: str) -> str:
    return files("driftform.search.report").joinpath(name).read_text(encoding="utf-8")


def _format_length(metres: float) -> str:
    return f"{1000 * metres:.0f} mm" if metres < 1 else f"{metres:.2f} m"
