"""``driftform simulate``."""

from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import typer

from driftform.cli.options import FILE, declare

BAR = 20
"""Width of the longest bar, columns."""

CHAOTIC = 0.01
"""Estimated error (m) above which a path is one of many."""

if TYPE_CHECKING:
    from collections.abc import Sequence

    from driftform.design.design import Design
    from driftform.design.flight import DisturbedFlights, Flight
    from driftform.types import Trajectory


@declare(
    FILE,
    *(
        "agent",
        "scenario",
        "simulator",
        "hydrodynamics",
        "out",
        "film",
        "still",
        "still_at",
        "renderer",
        "robust",
        "seed",
        "style",
        "width_mm",
        "settings",
        "json",
    ),
)
def simulate(given: SimpleNamespace) -> None:
    """Simulate one flight of an agent; show its closest approaches, its end and a picture.

    With --robust, also simulates flights under disturbed conditions, and shows by how much they miss and which
    disturbances contribute most.
    """
    from driftform.cli.formats import parse_page
    from driftform.cli.output import print_json
    from driftform.design.design import check_moment
    from driftform.design.opening import open_agent
    from driftform.errors import InputError
    from driftform.runs.table_files import write_trajectory
    from driftform.util.files import check_directory, make_directory
    from driftform.util.progress import count_progress

    page = parse_page(given.style, given.width_mm)
    design = open_agent(
        given.agent,
        given.scenario,
        given.settings or (),
        {"simulator": given.simulator, "hydrodynamics": given.hydrodynamics},
    )
    if given.still is None and given.still_at is not None:
        raise InputError("--still-at is the moment of a still: give --still FILE too")
    _check_pictures(design, given.film, given.still, given.renderer)
    folder = check_directory(given.out or Path("flights") / design.name)
    flight = design.simulate()
    check_moment(flight, given.still_at)
    make_directory(folder)
    csv, svg = folder / "trajectory.csv", folder / "flight.svg"
    write_trajectory(csv, flight.trajectory)
    pdf = next(iter(flight.draw(svg, page.width_mm)[1:]), None)
    if given.still is not None:
        design.still(given.still, at=given.still_at, renderer=given.renderer, flight=flight)
    if given.film is not None:
        with count_progress("frames") as progress:
            design.film(given.film, renderer=given.renderer, flight=flight, progress=progress)
    departures = [*design.list_limits(), *design.list_departures()]
    for line in departures:
        typer.echo(f"warning: {line}", err=True)
    misses = None
    if given.robust:
        with count_progress("disturbed flights") as progress:
            misses = design.disturb(given.robust, given.seed, progress)
    if given.json:
        print_json(
            {
                "agent": design.name,
                "simulator": design.pipeline.simulator.name,
                "hydrodynamics": design.pipeline.hydrodynamics.name,
                "fitness": flight.fitness,
                "closest": {name: {"distance": d, "t": t} for name, (d, t) in flight.approaches.items()},
                "end": {
                    "t": flight.duration,
                    "position": flight.trajectory.position[-1],
                    "reason": str(flight.end),
                    "outlet": flight.outlet,
                },
                "contact": flight.trajectory.contact,
                "energy_drift": flight.trajectory.energy_drift,
                "error": flight.trajectory.error,
                "trajectory": str(csv),
                "picture": str(svg),
                "film": None if given.film is None else str(given.film),
                "still": None if given.still is None else str(given.still),
                "warnings": departures,
                "disturbed": misses and _document(misses, flight.scenario.target_names),
                "disturbed_outlets": misses and misses.outlet_shares(flight.scenario),
                "disturbed_failures": misses and misses.failures,
            }
        )
        return
    _print(design, flight, misses)
    for what, made in (
        ("trajectory:", csv),
        ("picture:   ", svg),
        ("           ", pdf),
        ("film:      ", given.film),
        ("still:     ", given.still),
    ):
        if made is not None:
            print(f"{what} {made}")


def _check_pictures(design: "Design", film: Path | None, still: Path | None, renderer: str) -> None:
    """Refuse a film and a still that cannot be made, before the flight; the message names the option."""
    from driftform.errors import InputError
    from driftform.util.files import check_directory

    for option, path in (("--film", film), ("--still", still)):
        if path is None:
            continue
        what = f"--renderer {renderer}:"
        try:
            design.study.make_renderer(renderer)
            what = option
            design.check_picture(path, renderer, film=option == "--film")
        except InputError as error:
            raise InputError(f"{what} {error}") from None
        check_directory(path.parent, option)


def _print(design: "Design", flight: "Flight", misses: "DisturbedFlights | None") -> None:
    from driftform.cli.output import print_table
    from driftform.runs.wording import list_cells, list_headings

    fitness = design.pipeline.fitness
    header = ("target", *list_headings(fitness), "closest m", "at s")
    print_table(
        header,
        (
            (name, *list_cells(fitness, {"fitness": f}), f"{d:.4f}", f"{t:.2f}")
            for (name, f), (d, t) in zip(flight.fitness.items(), flight.approaches.values(), strict=True)
        ),
        right=range(1, len(header)),
    )
    pipeline, (x, y, z) = design.pipeline, flight.trajectory.position[-1]
    print(f"{design.name} flown by {pipeline.simulator.name}, {pipeline.hydrodynamics.name} coefficients")
    end = f"ended at the {flight.end}"
    if flight.outlet is not None and len(flight.scenario.pipe.layout.outlets) > 1:
        end = f"left through outlet {flight.outlet}"
    print(f"{end} after {flight.duration:.3f} s at x {x:.3f}, y {y:.3f}, z {z:.3f} m")
    print(_describe_accuracy(flight.trajectory))
    if misses is not None:
        _print_misses(misses, flight)


def _document(misses: "DisturbedFlights", targets: "Sequence[str]") -> dict[str, Any]:
    """Return, per target, the distances of all flights, their median and 90 % quantile, and the causes of the spread."""
    return {
        name: {
            "distances": misses.distances[:, number],
            **misses.describe(number),
            "causes": {effect.name: effect.deviation for effect in misses.list_effects(number) or ()},
        }
        for number, name in enumerate(targets)
    }


def _print_misses(misses: "DisturbedFlights", flight: "Flight") -> None:
    """Print the misses for every target, and what the miss of the target that the agent comes closest to depends on."""
    import numpy as np

    from driftform.cli.output import print_table, print_text
    from driftform.runs.wording import format_miss

    names = flight.scenario.target_names
    print(f"{misses.count} flights under disturbed conditions:")
    failed, known = np.isnan(misses.distances).sum(axis=0), misses.promised_in_known_gusts
    columns = {
        "nominal mm": [format_miss(flight.closest[name]) for name in names],
        "median mm": [*map(format_miss, misses.median)],
        "90 % mm": [*map(format_miss, misses.promised)],
        "90 % in known gusts": [] if known is None else [*map(format_miss, known)],
        "failed": failed.astype(str).tolist() if failed.any() else [],
    }
    shown = {heading: column for heading, column in columns.items() if column}
    print_table(("target", *shown), zip(names, *shown.values(), strict=True), right=range(1, 1 + len(shown)))
    if reason := misses.describe_failures():
        print_text(f"failed flights do not count; most often: {reason}")
    shares = misses.outlet_shares(flight.scenario)
    if len(shares) > 1:
        stayed = {"none": 1.0 - sum(shares.values())} if None in misses.outlets else {}
        print_table(
            ("left by outlet", "flights %"),
            ((name, f"{100 * share:.0f}") for name, share in {**shares, **stayed}.items()),
            right=(1,),
        )
    if not names:
        return
    nearest = int(misses.promised.argmin())
    effects = misses.list_effects(nearest)
    if effects is None:
        return
    print(f"the miss of {names[nearest]} depends on (standard deviation, mm):")
    longest = max(effect.deviation for effect in effects)
    print_table(
        ("cause", "mm", "", "what helps"),
        (
            (
                effect.name,
                format_miss(effect.deviation),
                "#" * round(BAR * effect.deviation / longest) if longest else "",
                effect.advice,
            )
            for effect in effects
        ),
        right=(1,),
    )


def _describe_accuracy(trajectory: "Trajectory") -> str:
    """How far the flight can be trusted, in one line; what the simulator does not report is left out."""
    facts = [
        "touches no wall" if trajectory.contact is None else f"first touches the wall after {trajectory.contact:.3f} s"
    ]
    if trajectory.energy_drift is not None:
        facts.append(f"energy drifts by {trajectory.energy_drift:.1e} until then")
    if trajectory.error is not None:
        chaotic = "; the path is chaotic, and others are as likely" if trajectory.error > CHAOTIC else ""
        facts.append(f"estimated error of the position {1000 * trajectory.error:.2g} mm{chaotic}")
    return "; ".join(facts)
