"""``driftform drop`` and ``driftform calibrate``."""

from pathlib import Path
from types import SimpleNamespace as Given

from driftform.cli import options


@options.declare(
    Path(__file__).with_name("drop.toml"),
    *("agent", "tank", "drops", "fps", "noise", "scenario", "hydrodynamics", "settings", "out", "json"),
)
def drop(given: Given) -> None:
    """Plan the drops in a tank whose films show most about the model: attitude, depth and ballast of each release.

    Writes a page to take to the tank (what to weigh, where to put the camera, a ruler to print) and a study file for each
    drop. Save the track of a film in the folder of its drop's file, for 'driftform calibrate'.
    """
    from driftform import open_agent
    from driftform.cli import output
    from driftform.util import files
    from driftform_calibration.experiment import drop_design

    use = {"hydrodynamics": given.hydrodynamics}
    design = open_agent(given.agent, *(given.settings or ()), scenario=given.scenario, use=use)
    directory = files.check_directory(given.out or Path("drops") / design.name)
    plan = drop_design(design, given.tank, drops=given.drops, fps=given.fps, noise=given.noise)
    paths = plan.write(directory)
    document = plan.document(paths)
    if given.json:
        output.print_json(document)
        return
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


@options.declare(
    Path(__file__).with_name("calibrate.toml"),
    *("agent", "tracks", "scenario", "unit", "scale", "scale_error", "distance", "fps", "y_down", "view", "point"),
    *("target", "fit", "printed_mass", "hydrodynamics", "style", "width_mm", "settings", "out", "json"),
)
def calibrate(given: Given) -> None:
    """Fit the model to tracks of filmed flights: drag, added mass, weight, restitution and friction.

    Prints each factor with its 90 % interval, or why the tracks do not show it. Writes the
    table [calibration] for any study, the calibrated agent, and pictures of the films against the flights.
    """
    from shlex import quote

    from driftform import open_agent
    from driftform.cli import formats, output
    from driftform.util import files
    from driftform_calibration.films import calibrate_design, find_scenario
    from driftform_calibration.tracks import Reading

    page = formats.parse_page(given.style, given.width_mm)
    settings, use = given.settings or [], {"hydrodynamics": given.hydrodynamics}
    # An agent that does not remember how it was built, such as a word, is built as the study of its first film says.
    scenario = given.scenario or find_scenario(given.tracks[0])
    design = open_agent(given.agent, *settings, scenario=scenario, use=use)
    directory = files.check_directory(given.out or Path("calibrations") / design.name)
    points = _read_points(given.point or [])
    reading = Reading(given.unit, given.scale, given.fps, given.y_down, given.target, points)
    asked = {name: getattr(given, name) for name in ("scenario", "view", "scale_error", "distance", "printed_mass")}
    asked |= {"settings": settings, "use": use, "reading": reading, "fit": given.fit or ()}
    found = calibrate_design(design, *given.tracks, **asked)
    paths = found.write(directory, page)
    if given.json:
        output.print_json({**found.document(), "files": [str(path) for path in paths]})
        return
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
