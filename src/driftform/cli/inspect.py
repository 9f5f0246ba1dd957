"""``driftform inspect``."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from driftform.cli.options import Agent, Hydrodynamics, Json, ScenarioOption, Settings

if TYPE_CHECKING:
    from driftform.cli.agents import Opened

LEAD = 11_340.0
"""Density of lead, kg/m3 (CRC Handbook of Chemistry and Physics, at 20 degrees C)."""

BED = 0.25
"""Travel of a common desktop printer, m."""

LAGGED = 17 / 3
"""Largest eigenvalue of M_RB^-1 M_A up to which added mass from a filtered acceleration is stable: 2/0.3 - 1."""


def inspect(
    agent: Agent,
    scenario: ScenarioOption = None,
    hydrodynamics: Hydrodynamics = None,
    settings: Settings = None,
    compare: Annotated[
        bool,
        typer.Option("--compare", help="The added mass of all installed hydrodynamics models side by side."),
    ] = False,
    json: Json = False,
) -> None:
    """Tell what a body is: its modules, mass, buoyancy, inertia, added mass, how it moves, and what to beware of."""
    from driftform.cli.agents import open_agent
    from driftform.cli.output import print_json

    opened = open_agent(agent, scenario, settings or (), {"hydrodynamics": hydrodynamics})
    facts = body_facts(opened)
    if compare:
        facts["compare"] = _compared(opened)
    if json:
        print_json(facts)
    else:
        _print(facts)


def body_facts(opened: "Opened") -> dict[str, Any]:
    """What there is to tell, SI units throughout."""
    import numpy as np

    from driftform.dynamics.inertia import added_mass_at, largest_added_mass_ratio, rigid_body_mass
    from driftform.dynamics.model import flight_model
    from driftform.dynamics.stability import stable_rest
    from driftform.geometry import hull_mass

    body, mass, coefficients = opened.agent.body, opened.agent.mass, opened.agent.coefficients
    fluid = opened.study.scenario.fluid
    own, added = rigid_body_mass(mass), added_mass_at(coefficients, np.zeros(3))
    lambda_max = largest_added_mass_ratio(mass, coefficients)
    net = (fluid.density * mass.volume - mass.mass) * fluid.gravity
    rest = stable_rest(flight_model(opened.agent, opened.study.scenario))
    morphology = opened.agent.morphology
    sides = [] if morphology is None else [("aft", m) for m in morphology.aft[::-1]]
    sides += [] if morphology is None else [("fore", m) for m in morphology.fore]
    return {
        "agent": opened.name,
        "genome": opened.pipeline.grammar.to_text(opened.stored.genome),
        "modules": [
            {"side": side, "length": m.length, "tilt_deg": float(np.rad2deg(m.tilt))} for side, m in sides
        ],
        "length": body.length,
        "max_diameter": body.max_diameter,
        "mass": mass.mass,
        "hull_mass": hull_mass(body),
        "core_mass": body.core.mass,
        "volume": mass.volume,
        "net_buoyancy": net,
        "cog": mass.cog,
        "cob": mass.cob,
        "inertia": mass.inertia,
        "added_mass": coefficients.added_mass,
        "added_mass_origin": coefficients.origin,
        "hydrodynamics": opened.pipeline.hydrodynamics.name,
        "rest": {
            "pitch_deg": float(np.rad2deg(rest.pitch)),
            "height": rest.height,
            "slowest_period": rest.slowest_period,
            "eigenvalues": [[value.real, value.imag] for value in rest.eigenvalues.tolist()],
        },
        "righting_moment": _righting_moment(opened),
        "terminal_speeds": _terminal_speeds(opened, net, rest.pitch),
        "lambda_max": lambda_max,
        "sensitivity": _sensitivity(opened),
        "warnings": _warnings(opened, float((own + added)[2, 2]), lambda_max),
    }


def _righting_moment(opened: "Opened") -> float:
    """Largest moment (N m) of weight and buoyancy about the COG: that of the level body."""
    mass, fluid = opened.agent.mass, opened.study.scenario.fluid
    return float(fluid.density * mass.volume * fluid.gravity * abs(mass.cob[0] - mass.cog[0]))


def _terminal_speeds(opened: "Opened", net: float, pitch: float) -> dict[str, float]:
    """Speeds (m/s) at which drag by strips carries the net weight, whether the agent flies with that drag or not."""
    from driftform.drag import drag_of
    from driftform.dynamics.terminal import terminal_speeds

    fluid = opened.study.scenario.fluid
    fore_first = (net > 0) == (pitch < 0)
    drag = opened.agent.coefficients.drag or drag_of(opened.agent.body, fluid.viscosity)
    along, across = terminal_speeds(drag, net, fore_first, fluid.density, fluid.viscosity)
    return {"along": along, "across": across}


def _sensitivity(opened: "Opened") -> dict[str, Any] | None:
    """Errors, in percent, of the agent and of one whose hull is a gram lighter or heavier; ``None`` where none can be told."""
    from driftform.errors import WorkFailedError
    from driftform.reflight import gram_sensitivity

    names = opened.study.scenario.target_names
    try:
        found = gram_sensitivity(opened.pipeline, opened.agent, opened.name) if names else None
    except WorkFailedError:
        # An agent that cannot be flown is still a body, and `simulate` tells what is wrong with its flight.
        return None
    if found is None:
        return None
    columns = ("as_simulated", "lighter", "heavier")
    rows = zip(*(getattr(found, column) for column in columns), strict=True)
    errors = {name: dict(zip(columns, row, strict=True)) for name, row in zip(names, rows, strict=True)}
    target = opened.stored.result.get("target")
    if target not in errors:
        target = min(errors, key=lambda name: float(errors[name]["as_simulated"]))
    return {"target": target, "errors": errors}


def _compared(opened: "Opened") -> dict[str, Any]:
    """Added mass about the centre of buoyancy by every hydrodynamics model that is installed.

    The study's own model has the study's options, the others have their defaults.
    """
    from driftform.dynamics.inertia import added_mass_at
    from driftform.errors import WorkFailedError
    from driftform.registry import registry

    own, found = opened.pipeline.hydrodynamics, {}
    for row in registry().seam("hydrodynamics"):
        if row.available:
            model = own if row.name == own.name else registry().create("hydrodynamics", row.name, {})
            try:
                coefficients = model.coefficients(opened.agent.body, opened.study.scenario.fluid)
            except (ValueError, ArithmeticError, RuntimeError) as error:
                raise WorkFailedError(
                    f"{opened.name}: no added mass by '{row.name}': {type(error).__name__}: {error}"
                ) from None
            found[row.name] = added_mass_at(coefficients, opened.agent.mass.cob)
    return found


def _warnings(opened: "Opened", heaving: float, lambda_max: float) -> list[str]:
    """What to beware of; ``heaving`` is the mass, kg, that heave has to move, with that of the water."""
    import math

    body, mass, scenario = opened.agent.body, opened.agent.mass, opened.study.scenario
    fluid = scenario.fluid
    warnings = []
    core_density = body.core.mass / (4 / 3 * math.pi * body.core.radius**3)
    if core_density > LEAD:
        warnings.append(f"the core is denser than lead: {core_density:.0f} kg/m3")
    net = (fluid.density * mass.volume - mass.mass) * fluid.gravity
    if scenario.pipe.segments and net != 0:
        time = math.sqrt(2 * scenario.pipe.segments[0].radius * heaving / abs(net))
        if time < 1.0:
            verb = "rises" if net > 0 else "sinks"
            warnings.append(
                f"level, it {verb} from the axis to the wall in {time:.2g} s: it is far from neutral"
            )
    if lambda_max > LAGGED:
        warnings.append(
            f"added mass up to {lambda_max:.1f} times its own: simulators that take it from the step before, "
            f"smoothed, diverge beyond {LAGGED:.2f}"
        )
    if body.length > BED or body.max_diameter > BED:
        warnings.append(
            f"{1000 * body.length:.0f} mm long and {1000 * body.max_diameter:.0f} mm wide: "
            f"larger than the bed of a common printer ({1000 * BED:.0f} mm)"
        )
    return warnings


def _print(facts: dict[str, Any]) -> None:
    import numpy as np

    from driftform.cli.output import print_table

    net = facts["net_buoyancy"]
    weight = "floats" if net > 0 else "sinks" if net < 0 else "hovers"
    modules = facts["modules"]
    aft = sum(m["side"] == "aft" for m in modules)
    rows = [
        ("modules", f"{len(modules)} ({aft} aft, {len(modules) - aft} fore of the core)"),
        ("length", f"{1000 * facts['length']:.2f} mm"),
        ("largest diameter", f"{1000 * facts['max_diameter']:.2f} mm"),
        ("mass", f"{1000 * facts['mass']:.3f} g"),
        ("  of it hull", f"{1000 * facts['hull_mass']:.3f} g"),
        ("  of it core", f"{1000 * facts['core_mass']:.3f} g"),
        ("displaced volume", f"{1e6 * facts['volume']:.3f} cm3"),
        ("net buoyancy", f"{net:+.4f} N (it {weight})"),
        ("centre of gravity", f"x {1000 * facts['cog'][0]:+.3f} mm from the core's centre"),
        ("centre of buoyancy", f"x {1000 * facts['cob'][0]:+.3f} mm"),
        (
            "inertia about the COG",
            f"axial {facts['inertia'][0, 0]:.4g}, transverse {facts['inertia'][1, 1]:.4g} kg m2",
        ),
    ]
    speeds = facts["terminal_speeds"]
    rows += [
        ("at rest", _rest(facts["rest"])),
        ("righting moment", f"{1000 * facts['righting_moment']:.3g} mN m, level"),
        (
            "terminal speed",
            f"{speeds['along']:.3g} m/s along its axis, {speeds['across']:.3g} across, with drag",
        ),
        ("added over own mass", f"at most {facts['lambda_max']:.3g}"),
        ("a gram of hull", _gram(facts["sensitivity"])),
    ]
    print_table(("agent", facts["agent"]), rows)
    if modules:
        print("\nmodules from aft to fore")
        print_table(
            ("side", "length mm", "tilt deg"),
            ((m["side"], f"{1000 * m['length']:.2f}", f"{m['tilt_deg']:+.1f}") for m in modules),
            right=(1, 2),
        )
    origin = ", ".join(f"{1000 * c:.3f}" for c in facts["added_mass_origin"])
    print(f"\nadded mass by {facts['hydrodynamics']} about ({origin}) mm; kg, kg m, kg m2")
    names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    matrix = np.asarray(facts["added_mass"])
    print_table(
        ("", *names),
        ((name, *(f"{v:.4g}" for v in row)) for name, row in zip(names, matrix, strict=True)),
        right=range(1, 7),
    )
    if "compare" in facts:
        print("\nthe same about the centre of buoyancy by each model; kg, kg m, kg m2")
        print_table(
            ("model", "M11 surge", "M22 sway", "M26 sway-yaw", "M55 pitch"),
            (
                (name, *(f"{m[i, j]:.4g}" for i, j in ((0, 0), (1, 1), (1, 5), (4, 4))))
                for name, m in facts["compare"].items()
            ),
            right=range(1, 5),
        )
    for warning in facts["warnings"]:
        print(f"beware: {warning}")


def _gram(sensitivity: dict[str, Any] | None) -> str:
    """What one gram does to the error at the agent's target, in words."""
    if sensitivity is None:
        return "what it does to a flight cannot be told"
    errors = sensitivity["errors"][sensitivity["target"]]
    return (
        f"{sensitivity['target']} missed by {errors['as_simulated']:.2f} % of d_max; "
        f"1 g less {errors['lighter']:.2f} %, 1 g more {errors['heavier']:.2f} %"
    )


def _rest(rest: dict[str, Any]) -> str:
    """How it hangs in still water, or floats on it, in words."""
    pitch = rest["pitch_deg"]
    attitude = f"pitched {pitch:+.1f} deg"
    if abs(pitch) > 89.9:
        attitude = "fore end down" if pitch > 0 else "fore end up"
    where = "turns" if rest["height"] is None else f"floats, its core {-1000 * rest['height']:.1f} mm under,"
    period = rest["slowest_period"]
    swings = "indifferent" if period is None else f"slowest oscillation {period:.3g} s"
    return f"{where} {attitude}; {swings}"
