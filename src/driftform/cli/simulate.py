"""``driftform simulate``."""

from pathlib import Path

from driftform.cli.options import (
    Agent,
    Hydrodynamics,
    Json,
    OutDirectory,
    ScenarioOption,
    Settings,
    Simulator,
)


def simulate(
    agent: Agent,
    scenario: ScenarioOption = None,
    simulator: Simulator = None,
    hydrodynamics: Hydrodynamics = None,
    out: OutDirectory = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Fly one agent: how close it comes to each target, where and why it ends, and a picture of its path."""
    from driftform.cli.agents import open_agent
    from driftform.cli.output import print_json, print_table
    from driftform.dynamics.path import closest_approach
    from driftform.errors import WorkFailedError
    from driftform.figures.flight import flight_svg
    from driftform.files import make_directory, write_text
    from driftform.run_directory import write_trajectory

    opened = open_agent(
        agent, scenario, settings or (), {"simulator": simulator, "hydrodynamics": hydrodynamics}
    )
    environment = opened.study.scenario
    folder = make_directory(out or Path("flights") / opened.name)
    try:
        [flight] = opened.pipeline.fly([opened.agent])
    except (ArithmeticError, RuntimeError) as error:
        raise WorkFailedError(f"{opened.name}: cannot be flown: {type(error).__name__}: {error}") from None
    if flight.end.failed:
        raise WorkFailedError(f"{opened.name}: the flight ended after {flight.t[-1]:.3g} s: {flight.end}")
    fitness = opened.pipeline.fitness.score(flight, environment)
    distance, when = closest_approach(flight, environment.target_array())

    csv, svg = folder / "trajectory.csv", folder / "flight.svg"
    write_trajectory(csv, flight)
    write_text(svg, flight_svg(flight, environment, opened.name, opened.agent.body))
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
                "trajectory": str(csv),
                "picture": str(svg),
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
    print(f"trajectory: {csv}")
    print(f"picture:    {svg}")
