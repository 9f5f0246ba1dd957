"""The paper's tables and figures, made of our own flights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from driftform import Study
from driftform.figures import files as picture_files
from driftform.figures import gallery, layout, plot, style, svg, trend
from driftform.motion import path
from driftform.types import FloatArray, Trajectory
from driftform.water import Scenario
from driftform_paper import repeats
from driftform_paper.repeats import RepeatedFlights, Search

COLUMNS = 2
LEFT, GUTTER, TOP = 52.0, 62.0, 108.0
NARROW = 500.0
"""Width of a page with one column, px."""

STATIONS = 240

SIDE = (0, 2)
"""x to the right and z upward on the page."""


def spread_svg(
    repeats: Mapping[str, tuple[Sequence[Trajectory], str]],
    scenario: Scenario,
    title: str,
    subtitle: str,
    page: style.Page = style.SCREEN,
) -> str:
    """Return a panel for each target with its flights and a note: each faint, their mean solid, one standard deviation as a band.

    Mean and deviation are those of the height at equal x, over the range of x that all flights cover.
    """
    columns = COLUMNS if page.width > NARROW else 1
    width = (page.width - LEFT - layout.MARGIN - (columns - 1) * GUTTER) / columns
    shown = np.vstack([plot.pipe_points(scenario.pipe), scenario.target_array()])
    tallest = plot.Window.around(SIDE, shown, LEFT, 0, width, 260, 6).box.bottom
    rows = ceil(len(repeats) / columns)
    height = TOP + rows * (tallest + 74)
    root = layout.start_page(height, title, subtitle, f"{subtitle} A panel for each target.", page)
    for number, (target, (flights, note)) in enumerate(repeats.items()):
        row, column = divmod(number, columns)
        left, top = LEFT + column * (width + GUTTER), TOP + row * (tallest + 74)
        window = plot.Window.around(SIDE, shown, left, top, width, 260, 6)
        _draw_panel(root, window, target, flights, scenario, style.SERIES[number % len(style.SERIES)])
        heading = layout.shorten(f"{target}  {note}".strip(), 12, 330, bold=True)
        layout.write(root, left, top - 8, heading, 12, bold=True)
    return svg.render(root)


def compute_band(flights: Sequence[Trajectory], target: FloatArray) -> tuple[list[FloatArray], FloatArray, FloatArray]:
    """Return the paths up to their closest approach to ``target`` (3,), their mean, and the standard deviation.

    Paths are (n, 3) each, the mean (k, 3), the deviation of the height (k,); world frame, m.
    """
    paths = []
    for flight in flights:
        _, [closest] = path.closest_approach(flight, target[None])
        t = np.linspace(flight.t[0], max(closest, flight.t[0] + 1e-6), STATIONS)
        paths.append(path.interpolate_positions(flight, np.minimum(t, flight.t[-1])))
    along = np.linspace(max(path[0, 0] for path in paths), min(path[:, 0].max() for path in paths), STATIONS)
    # A path may turn back for a moment: the first time at a station counts.
    heights = np.array([np.interp(along, np.maximum.accumulate(path[:, 0]), path[:, 2]) for path in paths])
    mean = np.column_stack([along, np.zeros_like(along), heights.mean(axis=0)])
    return paths, mean, heights.std(axis=0)


def _draw_panel(
    root: ET.Element, window: plot.Window, name: str, flights: Sequence[Trajectory], scenario: Scenario, colour: str
) -> None:
    plot.draw_water(root, window, scenario.pipe)
    plot.draw_axes(root, window)
    plot.draw_ends(root, window, scenario.pipe)
    target = np.array(scenario.target_points()[name])
    paths, mean, deviation = compute_band(flights, target)
    up = np.array([0.0, 0.0, 1.0])
    edge = [window.to_page(mean + sign * deviation[:, None] * up) for sign in (1, -1)]
    outline = np.vstack([edge[0], edge[1][::-1]])
    svg.add(root, "path", class_="band", d=svg.path_data(outline, closed=True), fill=style.tint(colour, 0.3))
    for line in paths:
        svg.add_line(root, window.path_data(line), style.tint(colour, 0.55), 0.8)
    svg.add_line(root, window.path_data(mean), colour, 2, "mean")
    x, y = window.to_page(target[None])[0]
    plot.draw_cross(root, x, y, 5, style.INK, 2)


TIMES = 10
"""How often each of the best agents is flown again."""

SHAPES_TOP = 130.0
"""Upper edge of the bodies in their picture, px."""


@dataclass(frozen=True, eq=False)
class Resimulation:
    """The best agents flown again: under the very same conditions, and in turbulent water of the same mean speed."""

    same: RepeatedFlights
    turbulent: RepeatedFlights


def resimulate(study: Study, search: Search) -> Resimulation:
    """Fly the best agents of a search again, :data:`TIMES` times each way."""
    pipeline = study.make_pipeline()
    genomes = [genome for genome, _, _ in search.best]
    return Resimulation(
        repeats.repeat_flights(pipeline, genomes, [study.scenario] * TIMES),
        repeats.repeat_flights(pipeline, genomes, repeats.add_turbulence(study.scenario, range(TIMES))),
    )


def results_document(scenario: Scenario, found: Mapping[str, Search], again: Resimulation) -> dict[str, Any]:
    """The tables as data: for each strategy and target the mean, standard deviation and worst error, %."""
    return {
        "targets": {
            target: {
                **{
                    name: {
                        "mean": float(search.error[:, number].mean()),
                        "std": float(search.error[:, number].std()),
                        "worst": float(search.error[:, number].max()),
                    }
                    for name, search in found.items()
                },
                "resimulated_std": float(again.same.deviation[number]),
                "turbulent_mean": float(again.turbulent.error[number]),
                "turbulent_std": float(again.turbulent.deviation[number]),
                "turbulent_failed": again.turbulent.failed[number],
            }
            for number, target in enumerate(scenario.target_names)
        },
        "failed": {name: search.failed for name, search in found.items()},
    }


def results_markdown(scenario: Scenario, found: Mapping[str, Search], again: Resimulation) -> str:
    """The tables as Markdown, with what of the paper's claims can be compared."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    heights = []
    for target, flights in zip(scenario.target_names, again.turbulent.flights, strict=True):
        sound = [flight for flight in flights if flight.failure is None]
        band = compute_band(sound, np.array(scenario.target_points()[target])) if sound else None
        heights.append(np.nan if band is None else band[2].max())
    loader = PackageLoader(__package__, "")
    environment = Environment(loader=loader, undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True)
    return environment.get_template("results.txt").render(
        targets=scenario.target_names,
        paper=found["paper"],
        random=found["random"],
        shared=[100 - found[name].shared.mean(axis=0) for name in ("paper", "random")],
        again=again,
        most_turbulent=np.nanmax(again.turbulent.deviation),
        heights=heights,
        times=TIMES,
        per_target=repeats.PER_TARGET,
    )


def write_figures(
    directory: Path, study: Study, found: Mapping[str, Search], again: Resimulation, page: style.Page = style.SCREEN
) -> tuple[Path, ...]:
    """Write the paper's Figures 5 to 7 of our own flights, and return the files."""
    scenario, paper, random = study.scenario, found["paper"], found["random"]
    pictures = {
        "fitness.svg": trend.trend_svg(
            draw_generations(scenario.target_names, paper.fitness, random.fitness),
            "Fitness over generations",
            f"Fitness (%) after each generation for the target: mean and standard deviation over {len(paper.fitness)} repeats",
            page,
        ),
        "shapes.svg": _shapes(study, paper, again, page),
        "trajectories.svg": spread_svg(
            {
                target: (flights, f"error {error:.2f} %")
                for target, flights, error in zip(
                    scenario.target_names, again.turbulent.flights, again.turbulent.error, strict=True
                )
            },
            scenario,
            "The best agents in turbulent water",
            f"{TIMES} flights each up to their closest approach, with their mean and standard deviation",
            page,
        ),
    }
    return tuple(
        path for name, svg in pictures.items() for path in picture_files.write_picture(directory / name, svg, page)
    )


def draw_generations(targets: Sequence[str], fitness: FloatArray, random: FloatArray) -> dict[str, list[trend.Curve]]:
    """Return the curves of the paper's search and of random search, by targets, of (repeats, targets, flights).

    Without elitism, the best of the last generation may be worse than the best so far: both are drawn.
    """
    flights = np.arange(repeats.GENERATION, fitness.shape[2] + 1, repeats.GENERATION)
    split = (*fitness.shape[:2], len(flights), repeats.GENERATION)
    each, other = (values[:, :, : flights[-1]].reshape(split).max(axis=3) for values in (fitness, random))
    drawn = {
        "the paper's genetic algorithm: best so far": np.maximum.accumulate(each, axis=2),
        "best of each generation": each,
        "random search: best so far": np.maximum.accumulate(other, axis=2),
    }
    return {
        target: [trend.Curve.of_mean(name, flights, values[:, number]) for name, values in drawn.items()]
        for number, target in enumerate(targets)
    }


def _shapes(study: Study, search: Search, again: Resimulation, page: style.Page) -> str:
    pipeline = study.make_pipeline()
    flights = [
        gallery.GalleryEntry(target, pipeline.make_agent(genome), flown[0], float(100 - fitness[0]))
        for target, (genome, _, _), flown, fitness in zip(
            study.scenario.target_names, search.best, again.same.flights, again.same.fitness, strict=True
        )
    ]
    rows, px_per_m = gallery.arrange_rows(flights, page)
    subtitle = f"The best agent for each target over {len(search.error)} repeats, with its error"
    description = f"Bodies of revolution at one scale: {', '.join(study.scenario.target_names)}. {subtitle}"
    height = SHAPES_TOP + sum(row.height for row in rows) + 2
    root = layout.start_page(height, "The best shapes", subtitle, description, page)
    gallery.draw_gallery(root, rows, px_per_m, SHAPES_TOP, page)
    return svg.render(root)
