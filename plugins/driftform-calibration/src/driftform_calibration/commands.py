"""``driftform drop`` and ``driftform calibrate``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from driftform.cli import options

if TYPE_CHECKING:
    from driftform_calibration.protocol import DropPlan
    from driftform_calibration.result import CalibrationResult


def drop(
    agent: options.Agent,
    tank: Annotated[
        tuple[float, float, float],
        typer.Option(
            metavar="LENGTH WIDTH DEPTH", help="Inside of the tank: along the picture, across it, of water; m."
        ),
    ] = (1.0, 0.5, 0.5),
    drops: Annotated[int, typer.Option(metavar="N", min=1, max=20, help="Number of drops to film.")] = 3,
    fps: Annotated[float, typer.Option(metavar="N", min=1, max=10_000, help="Frames per second of the film.")] = 60.0,
    noise: Annotated[
        float, typer.Option(metavar="M", min=1e-6, max=1, help="Standard deviation of a tracked point, m.")
    ] = 0.002,
    scenario: Annotated[
        str, typer.Option(metavar="NAME|FILE", help="Scenario with the water and the contact of the floor.")
    ] = "tank",
    hydrodynamics: options.Hydrodynamics = None,
    settings: options.Settings = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Directory for the files; by default drops/AGENT.")
    ] = None,
    json: options.Json = False,
) -> None:
    """Plan the drops in a tank whose films show most about the model: attitude, depth and ballast of each release.

    Writes a page to take to the tank (what to weigh, where to put the camera, a ruler to print) and a study file for each
    drop. Save the track of a film in the folder of its drop's file, for 'driftform calibrate'.
    """
    from driftform import open_agent
    from driftform.cli import output
    from driftform.util import files, progress
    from driftform_calibration.experiment import drop_design

    design = open_agent(agent, *(settings or ()), scenario=scenario, use={"hydrodynamics": hydrodynamics})
    directory = files.check_directory(out or Path("drops") / design.name)
    with progress.count_progress("releases") as show:
        plan = drop_design(design, tank, drops=drops, fps=fps, noise=noise, progress=show)
    paths = plan.write(directory)
    if json:
        output.print_json(plan.document(paths))
    else:
        _print_plan(plan, paths)


def _print_plan(plan: "DropPlan", paths: list[Path]) -> None:
    from driftform.cli import output

    document = plan.document()
    output.print_table(*plan.tabulate(), right=(0, 1, 3, 4, 5, 7))
    print()
    output.print_table(*plan.tabulate_expected(), right=(1,))
    output.print_text(
        f"weigh the print with core and ballast: {1000 * document['mass']:.2f} g as simulated; calibrate takes it as --printed-mass"
    )
    for path in paths:
        print(f"wrote {path}")
    tracks = " ".join(f"{path.with_suffix('.csv')}" for path in paths[1:])
    print(f"next: driftform calibrate AGENT {tracks}")


def calibrate(
    agent: options.Agent,
    tracks: Annotated[
        list[Path],
        typer.Argument(
            metavar="TRACK",
            help="Tracks of filmed flights: CSV with the columns t, x, y, and z if known, or an export of Tracker, Kinovea, SLEAP, TrackMate, trackpy or DeepLabCut. "
            "NAME.toml in the folder of NAME.csv is the scenario of that film.",
        ),
    ],
    scenario: Annotated[
        str | None,
        typer.Option(metavar="NAME|FILE", help="Scenario of all films, such as tank; by default the agent's own."),
    ] = None,
    unit: Annotated[str | None, typer.Option(metavar="m|cm|mm", help="Unit of the coordinates; by default m.")] = None,
    scale: Annotated[
        float | None, typer.Option(metavar="M", help="Metres per pixel, if the coordinates are pixels.")
    ] = None,
    scale_error: Annotated[
        float,
        typer.Option(metavar="SHARE", min=0, max=0.2, help="Standard deviation of the film's scale, relative to it."),
    ] = 0.005,
    distance: Annotated[
        float, typer.Option(metavar="M", min=0.1, max=1000, help="Distance of the camera, m; nearer films show less.")
    ] = 2.5,
    fps: Annotated[
        float | None, typer.Option(metavar="N", help="Frames per second, if the file has frames and no times.")
    ] = None,
    y_down: Annotated[
        bool | None,
        typer.Option("--y-down/--y-up", help="Direction of y; by default down for pixels, and up otherwise."),
    ] = None,
    view: Annotated[
        str, typer.Option(metavar="side|top|front", help="Side that the camera looks from, for tracks in a plane.")
    ] = "side",
    point: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=X",
            help="Position of a tracked point on the axis, m from the core's centre, fore positive; repeatable.",
        ),
    ] = None,
    target: Annotated[
        str | None, typer.Option("--object", metavar="NAME", help="Tracked object, if there are several.")
    ] = None,
    fit: Annotated[
        list[str] | None, typer.Option(metavar="FACTOR", help="Fit only this factor; repeatable. By default all.")
    ] = None,
    printed_mass: Annotated[
        float | None, typer.Option(metavar="KG", help="Mass of the print with core and ballast, by scales, kg.")
    ] = None,
    hydrodynamics: options.Hydrodynamics = None,
    style: options.Style = "screen",
    width_mm: options.WidthMm = None,
    settings: options.Settings = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Directory for the files; by default calibrations/AGENT.")
    ] = None,
    json: options.Json = False,
) -> None:
    """Fit the model to tracks of filmed flights: drag, added mass, weight, restitution and friction.

    Prints each factor with its 90 % interval, or why the tracks do not show it. Writes the
    table [calibration] for any study, the calibrated agent, and pictures of the films against the flights.
    """
    from driftform import open_agent
    from driftform.cli import formats, output
    from driftform.util import files
    from driftform_calibration.films import calibrate_design, find_scenario
    from driftform_calibration.tracks import Reading

    page = formats.parse_page(style, width_mm)
    settings, use = settings or [], {"hydrodynamics": hydrodynamics}
    # An agent that does not remember how it was built, such as a word, is built as the study of its first film says.
    design = open_agent(agent, *settings, scenario=scenario or find_scenario(tracks[0]), use=use)
    directory = files.check_directory(out or Path("calibrations") / design.name)
    reading = Reading(unit, scale, fps, y_down, target, _read_points(point or []))
    found = calibrate_design(
        design,
        *tracks,
        scenario=scenario,
        settings=settings,
        use=use,
        reading=reading,
        view=view,
        scale_error=scale_error,
        distance=distance,
        fit=fit or (),
        printed_mass=printed_mass,
    )
    paths = found.write(directory, page)
    if json:
        output.print_json({**found.document(), "files": [str(path) for path in paths]})
    else:
        _print_result(found, paths)


def _read_points(texts: list[str]) -> dict[str, float]:
    from driftform.errors import InputError

    points = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            points[name] = float(value)
        except ValueError:
            equals = ""
        if not equals or not name:
            raise InputError(f"--point {text}: expected NAME=X, such as nose=0.031 (m from the core's centre)")
    return points


def _print_result(found: "CalibrationResult", paths: list[Path]) -> None:
    from shlex import quote

    from driftform.cli import output

    output.print_table(*found.tabulate(), right=(1,))
    hull = found.fit.estimates["hull_density"]
    if hull.low is not None and hull.high is not None and not hull.low < 1 < hull.high:
        output.print_text(f"the hull weighs {hull.value:.4g} times what was simulated: that changes the net weight")
    print()
    off = ("residual_before", "residual")
    tracks = [
        (row["track"], f"{row['points']}", f"{1000 * row['noise']:.2f}", *(f"{1000 * row[k]:.1f}" for k in off))
        for row in found.document()["tracks"]
    ]
    output.print_table(("track", "points", "noise mm", "before mm", "after mm"), tracks, right=range(1, 5))
    output.print_text(
        f"root mean square distance of films and flights: {1000 * found.fit.before:.1f} mm before, "
        f"{1000 * found.residual:.1f} mm after"
    )
    for note in found.notes:
        output.print_text(f"note: {note}")
    for path in paths:
        print(f"wrote {path}")
    if found.fit.known:
        print(f"next: driftform evolve --calibration {quote(str(paths[0]))}")
    else:
        print("next: driftform drop AGENT, which plans the drops that show most")
