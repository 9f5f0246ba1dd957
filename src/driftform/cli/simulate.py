"""``driftform simulate``."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from driftform.cli.options import (
    Agent,
    Film,
    Hydrodynamics,
    Json,
    OutDirectory,
    Renderer,
    Robust,
    ScenarioOption,
    Settings,
    Simulator,
    Still,
    StillAt,
)
from driftform.errors import InputError, WorkFailedError

if TYPE_CHECKING:
    from driftform.agents.opening import Opened
    from driftform.interfaces import Renderer as RendererPlugin
    from driftform.scenario.disturbances import Spread
    from driftform.types import Evaluation, Trajectory


def simulate(
    agent: Agent,
    scenario: ScenarioOption = None,
    simulator: Simulator = None,
    hydrodynamics: Hydrodynamics = None,
    out: OutDirectory = None,
    film: Film = None,
    still: Still = None,
    still_at: StillAt = None,
    renderer: Renderer = "exudyn",
    robust: Robust = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Fly one agent: how close it comes to each target, where and why it ends, a picture of its path, and a film or a still if wanted.

    With --robust it is flown many more times, each time a little different from what was planned.
    """
    from driftform.agents.opening import open_agent
    from driftform.cli.output import print_json, print_table
    from driftform.figures.flight import flight_svg
    from driftform.runs.directory import write_trajectory
    from driftform.trajectory.approach import closest_approach
    from driftform.util.files import make_directory, write_text
    from driftform.util.progress import count_progress

    disturbed = () if robust is None else (f"robustness.conditions={robust}",)
    opened = open_agent(
        agent,
        scenario,
        (*(settings or ()), *disturbed),
        {"simulator": simulator, "hydrodynamics": hydrodynamics},
    )
    environment = opened.study.scenario
    if still is None and still_at is not None:
        raise InputError("--still-at is the moment of a still: say --still FILE too")
    camera = None if film is None and still is None else _camera(opened, renderer, film, still)
    flight = opened.fly()
    end = float(flight.t[-1])
    if still_at is not None and not flight.end.failed and not 0 <= still_at <= end:
        raise InputError(f"--still-at {still_at:g}: the flight goes from 0 to {end:.3f} s")
    for option, path in (("--film", film), ("--still", still)):
        if path is not None:
            make_directory(path.parent, option)
    folder = make_directory(out or Path("flights") / opened.name)
    if flight.end.failed:
        raise WorkFailedError(f"{opened.name}: the flight ended after {end:.3g} s: {flight.end}")
    fitness = opened.pipeline.fitness.score(flight, environment)
    distance, when = closest_approach(flight, environment.target_array())

    csv, svg = folder / "trajectory.csv", folder / "flight.svg"
    write_trajectory(csv, flight)
    write_text(svg, flight_svg(flight, environment, opened.name, opened.agent.body))
    if camera is not None and still is not None:
        closest = float(when[distance.argmin()]) if len(when) else end / 2
        moment = closest if still_at is None else still_at
        camera.still(opened.agent, flight, environment, still, moment)
    if camera is not None and film is not None:
        with count_progress("frames") as progress:
            camera.film(opened.agent, flight, environment, film, progress)
    spread = _spread(opened)
    x, y, z = flight.position[-1]
    if json:
        print_json(
            {
                "agent": opened.name,
                "simulator": opened.pipeline.simulator.name,
                "hydrodynamics": opened.pipeline.hydrodynamics.name,
                "fitness": dict(zip(environment.target_names, fitness, strict=True)),
                "closest": {
                    name: {"distance": d, "t": t}
                    for name, d, t in zip(environment.target_names, distance, when, strict=True)
                },
                "end": {"t": flight.t[-1], "position": [x, y, z], "reason": str(flight.end)},
                "contact": flight.contact,
                "energy_drift": flight.energy_drift,
                "error": flight.error,
                "trajectory": str(csv),
                "picture": str(svg),
                "film": None if film is None else str(film),
                "still": None if still is None else str(still),
                "robust": spread and spread.document(environment.target_names),
            }
        )
        return
    print_table(
        ("target", "fitness %", "error % of d_max", "closest m", "at s"),
        (
            (name, f"{f:.3f}", f"{100 - f:.3f}", f"{d:.4f}", f"{t:.2f}")
            for name, f, d, t in zip(environment.target_names, fitness, distance, when, strict=True)
        ),
        right=(1, 2, 3, 4),
    )
    print(
        f"{opened.name} flown by {opened.pipeline.simulator.name}, {opened.pipeline.hydrodynamics.name} coefficients"
    )
    print(f"ended at the {flight.end} after {flight.t[-1]:.3f} s at x {x:.3f}, y {y:.3f}, z {z:.3f} m")
    print(_trust(flight))
    if spread is not None:
        print_table(
            ("target", "undisturbed error %", "disturbed: mean", "90 % below", "worst"),
            (
                (name, *(f"{100 - value:.3f}" for value in (f, *values)))
                for name, f, *values in zip(
                    environment.target_names, fitness, spread.mean, spread.tenth, spread.worst, strict=True
                )
            ),
            right=(1, 2, 3, 4),
        )
        print(spread.describe())
    print(f"trajectory: {csv}")
    print(f"picture:    {svg}")
    for what, made in (("film: ", film), ("still:", still)):
        if made is not None:
            print(f"{what}      {made}")


def _spread(opened: "Opened") -> "Spread | None":
    """Fitness over the disturbed conditions of the scenario, ``None`` where it has none."""
    import numpy as np

    from driftform.scenario.disturbances import measure_spread
    from driftform.util.progress import count_progress

    count = len(opened.pipeline.conditions)
    if not count:
        return None
    evaluations: list[Evaluation] = []
    with count_progress("disturbed flights") as progress:
        for number in range(count):
            evaluations += opened.pipeline.evaluate([opened.stored.genome], disturbed=[number])
            progress(len(evaluations), count)
    fitness = np.array([evaluation.fitness for evaluation in evaluations])
    return measure_spread(fitness, sum(evaluation.failure is not None for evaluation in evaluations))


def _camera(opened: "Opened", name: str, film: Path | None, still: Path | None) -> "RendererPlugin[Any]":
    """The renderer, after all was refused of its film and its still that can be before the flight."""
    from driftform.util.files import is_directory

    try:
        renderer = opened.study.make_renderer(name)
    except InputError as error:
        raise InputError(f"--renderer {name}: {error}") from None
    asked = (("--film", film, renderer.check), ("--still", still, renderer.check_still))
    for option, path, check in asked:
        if path is None:
            continue
        try:
            check(path)
        except InputError as error:
            raise InputError(f"{option} {error}") from None
        if is_directory(path):
            raise InputError(f"{option} {path}: is a directory")
    return renderer


def _trust(trajectory: "Trajectory") -> str:
    """How far the flight can be trusted, in one line; what the simulator does not tell is left out."""
    told = [
        "touches no wall"
        if trajectory.contact is None
        else f"first touches the wall after {trajectory.contact:.3f} s"
    ]
    if trajectory.energy_drift is not None:
        told.append(f"energy drifts by {trajectory.energy_drift:.1e} until then")
    if trajectory.error is not None:
        told.append(f"estimated error of the position {1000 * trajectory.error:.2g} mm")
    return "; ".join(told)
