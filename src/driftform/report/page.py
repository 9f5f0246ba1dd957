"""Contents -> one HTML page."""

import json
from html import escape
from importlib.resources import files

from driftform.geometry import hull_mass
from driftform.report.contents import Contents, Entry, viewer_data

GOOD, FAIR = 1.0, 5.0
"""Errors (%) up to which a target counts as reached, and as nearly reached: the paper's claim is 5 %."""


def page_html(contents: Contents) -> str:
    """Return the page: a summary first, then pictures, agents and the viewer. It loads nothing from anywhere."""
    resources = files("driftform.report")
    style = resources.joinpath("page.css").read_text(encoding="utf-8")
    script = resources.joinpath("viewer.js").read_text(encoding="utf-8")
    title = str(contents.study.document.get("title", "")) or contents.name
    # A script's text ends at "</", wherever it stands.
    data = json.dumps(viewer_data(contents), separators=(",", ":")).replace("</", "<\\/")
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="driftform">
<link rel="icon" href="data:,">
<title>{escape(contents.name)} - {escape(title)}</title>
<style>
{style}</style>
</head>
<body>
<main>
<header>
<h1>{escape(title)}</h1>
<p class="lead">{_lead(contents)}</p>
{_numbers(contents)}
</header>
<section aria-labelledby="h-agents">
<h2 id="h-agents">The best agent for each target</h2>
<div class="card scroll" tabindex="0" role="region" aria-labelledby="h-agents">
{_table(contents)}
</div>
</section>
<section aria-labelledby="h-view">
<h2 id="h-view">Look at one</h2>
<div class="bar" role="group" aria-label="Agent">
{_buttons(contents)}
</div>
<div class="views">
<div class="card">
<h3>The agent for <span id="agent-name"></span></h3>
<canvas id="agent-view" tabindex="0" role="img" aria-label="The agent in three dimensions. Arrow keys turn it, plus and minus zoom, Home resets."></canvas>
<div class="bar"><label><input type="checkbox" id="cut"> Cut open</label>{_zoom("agent")}</div>
</div>
<div class="card">
<h3>Its flight, the agent {viewer_data(contents)["magnification"]:g} times as large</h3>
<canvas id="flight-view" tabindex="0" role="img" aria-label="The flight through the pipe. Arrow keys turn it, plus and minus zoom, Home resets."></canvas>
<div class="bar">
<button type="button" id="play">Play</button>
<input type="range" id="time" min="0" max="1000" step="1" value="0" aria-label="Time of the flight">
{_zoom("flight")}
</div>
<p class="told" id="told"></p>
</div>
</div>
</section>
<section aria-labelledby="h-figures">
<h2 id="h-figures">Pictures</h2>
{"".join(f'<figure class="card figure" aria-label="{escape(name)}" style="margin-inline:0">{svg}</figure>' for name, svg in contents.figures.items())}
</section>
<section aria-labelledby="h-sections">
<h2 id="h-sections">Sections</h2>
<div class="sections">
{"".join(f'<div class="card figure">{svg}</div>' for svg in contents.sections)}
</div>
</section>
<section aria-labelledby="h-made">
<h2 id="h-made">How it was made</h2>
{_made(contents)}
</section>
</main>
<script type="application/json" id="data">{data}</script>
<script>
{script}</script>
</body>
</html>
"""


def _lead(contents: Contents) -> str:
    errors = [entry.error_percent for entry in contents.entries]
    reached = sum(error <= GOOD for error in errors)
    worst = max(contents.entries, key=lambda entry: entry.error_percent)
    of = "The target is" if len(errors) == 1 else f"{reached} of {len(errors)} targets are"
    if len(errors) == 1 and not reached:
        of = "The target is not"
    return (
        f"{of} reached within {GOOD:g} % of the farthest distance in the pipe; the worst is "
        f"{escape(worst.target)} with {worst.error_percent:.2f} %, {_length(worst.distance)} away."
    )


def _numbers(contents: Contents) -> str:
    rate = contents.evaluations / contents.seconds if contents.seconds else 0.0
    numbers = {
        "flights": f"{contents.evaluations}",
        "failed": f"{contents.failed}",
        "time of all flights": f"{contents.seconds:.0f} s"
        if contents.seconds < 600
        else f"{contents.seconds / 60:.0f} min",
        "per processor": f"{rate:.3g} flights/s",
        "strategy": str(contents.study.document.get("strategy", {}).get("use", "")),
        "seed": f"{contents.study.seed}",
    }
    rows = "".join(f"<div><dt>{escape(k)}</dt><dd>{escape(v)}</dd></div>" for k, v in numbers.items())
    return f'<dl class="numbers">{rows}</dl>'


def _length(metres: float) -> str:
    return f"{1000 * metres:.0f} mm" if metres < 1 else f"{metres:.2f} m"


def _grade(error: float) -> tuple[str, str]:
    if error <= GOOD:
        return "good", "reached"
    return ("fair", "near") if error <= FAIR else ("poor", "missed")


def _table(contents: Contents) -> str:
    has_spread = any("robust" in entry.stored.result for entry in contents.entries)
    head = (
        *(
            "target",
            "at (m)",
            "",
            "error %",
            "closest",
            "at s",
            "length mm",
            "diameter mm",
            "mass g",
            "hull g",
        ),
        *(("disturbed: mean %", "worst %") if has_spread else ()),
        "evaluation",
    )
    rows = "".join(_row(contents, entry, has_spread) for entry in contents.entries)
    cells = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    return f"<table><thead><tr>{cells}</tr></thead><tbody>{rows}</tbody></table>"


def _row(contents: Contents, entry: Entry, has_spread: bool) -> str:
    kind, word = _grade(entry.error_percent)
    body, mass = entry.agent.body, entry.agent.mass
    robust = entry.stored.result.get("robust", {})
    spread = (f"{100 - robust['mean']:.2f}", f"{100 - robust['worst']:.2f}") if robust else ("", "")
    cells = (
        ", ".join(f"{c:g}" for c in contents.scenario.targets[entry.target]),
        f'<span class="{kind}">{word}</span>',
        f"{entry.error_percent:.3f}",
        _length(entry.distance),
        f"{entry.t:.2f}",
        f"{1000 * body.length:.1f}",
        f"{1000 * body.max_diameter:.1f}",
        f"{1000 * mass.mass:.1f}",
        f"{1000 * hull_mass(body):.1f}",
        *(spread if has_spread else ()),
        f"{entry.index}",
    )
    return (
        f'<tr><th scope="row">{escape(entry.target)}</th>{"".join(f"<td>{cell}</td>" for cell in cells)}</tr>'
    )


def _buttons(contents: Contents) -> str:
    return "".join(
        f'<button type="button" data-agent="{number}" aria-pressed="false">{escape(entry.target)}</button>'
        for number, entry in enumerate(contents.entries)
    )


def _zoom(view: str) -> str:
    return (
        f'<button type="button" id="{view}-out" aria-label="Zoom out">&minus;</button>'
        f'<button type="button" id="{view}-in" aria-label="Zoom in">+</button>'
        f'<button type="button" id="{view}-home">Reset</button>'
    )


def _made(contents: Contents) -> str:
    import tomli_w

    seams = {
        seam: str(contents.study.document[seam]["use"])
        for seam in ("grammar", "builder", "hydrodynamics", "simulator", "fitness", "strategy")
        if seam in contents.study.document
    }
    rows = "".join(f'<tr><th scope="row">{escape(k)}</th><td>{escape(v)}</td></tr>' for k, v in seams.items())
    study = escape(tomli_w.dumps(dict(contents.study.document)))
    genomes = "".join(
        f"<p><strong>{escape(entry.target)}</strong><br><code>{escape(' '.join(entry.stored.genome.symbols))}</code></p>"
        for entry in contents.entries
    )
    return (
        f'<div class="card scroll"><table style="width:auto">{rows}</table></div>'
        f'<details class="card"><summary>Genomes</summary>{genomes}</details>'
        f'<details class="card"><summary>The study, with every default filled in</summary>'
        f'<pre class="scroll"><code>{study}</code></pre></details>'
    )
