"""``driftform inspect``."""

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from driftform.cli.options import FILE, declare

if TYPE_CHECKING:
    from driftform.interfaces import Fitness


@declare(FILE, "agent", "scenario", "hydrodynamics", "settings", "compare", "block", "json")
def inspect(given: SimpleNamespace) -> None:
    """Show an agent's modules, mass, buoyancy, inertia, added mass and warnings."""
    from driftform.cli.output import print_json
    from driftform.design.opening import open_agent
    from driftform.errors import InputError

    if given.block is not None and (given.compare or given.json):
        raise InputError("--block prints a part of a file: leave out --compare and --json")
    design = open_agent(given.agent, given.scenario, given.settings or (), {"hydrodynamics": given.hydrodynamics})
    if given.block is not None:
        print(design.describe_water(given.block), end="")
        return
    facts = design.inspect()
    if given.compare:
        facts["compare"] = design.compare_added_mass()
    if given.json:
        print_json(facts)
    else:
        _print(facts, design.pipeline.fitness)


def _print(facts: dict[str, Any], fitness: "Fitness[Any]") -> None:
    import numpy as np

    from driftform.cli.output import print_table, print_text

    net = facts["net_buoyancy"]
    weight = "floats" if net > 0 else "sinks" if net < 0 else "hovers"
    modules, pockets = facts["modules"], facts["pockets"]
    aft = sum(m["side"] == "aft" for m in modules)
    # Your own body has neither modules nor a core.
    origin, parts = "volume's", []
    if modules or facts["core_mass"] > 0:
        origin, parts = "core's", ["hull", "core", *(["ballast"] if facts["ballast_mass"] else [])]
    rows = [
        *([("modules", f"{len(modules)} ({aft} aft, {len(modules) - aft} fore of the core)")] if parts else []),
        ("length", f"{1000 * facts['length']:.2f} mm"),
        ("largest diameter", f"{1000 * facts['max_diameter']:.2f} mm"),
        ("mass", f"{1000 * facts['mass']:.3f} g"),
        *((f"  of it {part}", f"{1000 * facts[f'{part}_mass']:.3f} g") for part in parts),
        ("displaced volume", f"{1e6 * facts['volume']:.3f} cm3"),
        ("net buoyancy", f"{net:+.4f} N (it {weight})"),
        ("centre of gravity", f"x {1000 * facts['cog'][0]:+.3f} mm from the {origin} centre"),
        ("centre of buoyancy", f"x {1000 * facts['cob'][0]:+.3f} mm"),
        ("inertia about the COG", f"axial {facts['inertia'][0, 0]:.4g}, transverse {facts['inertia'][1, 1]:.4g} kg m2"),
    ]
    speeds = facts["terminal_speeds"]
    if pockets:
        least, most = (1000 * weight for weight in facts["trim_range"])
        rows.append(("trim pockets", f"{len(pockets)}, for {least:+.2f} to {most:+.2f} g of net weight"))
    for one in facts["fittings"]:
        drag = f"{1000 * one['mass']:+.3f} g; its drag, at most {1000 * one['drag_left_out']:.2g} mN at 0.1 m/s, added mass and contact are left out"
        rows.append((one["name"], drag))
    rows += [
        ("at rest", _describe_rest(facts["rest"])),
        ("righting moment", f"{1000 * facts['righting_moment']:.3g} mN m, level"),
        ("terminal speed", f"{speeds['along']:.3g} m/s along its axis, {speeds['across']:.3g} across, with drag"),
        ("added over own mass", f"at most {facts['lambda_max']:.3g}"),
        *(("O-ring", seal["summary"]) for seal in facts["seals"]),
        *([("under pressure", facts["strength"]["summary"])] if facts["strength"] else []),
        ("a gram of hull", _describe_gram(facts["sensitivity"], fitness)),
    ]
    for name, found in facts["calibration"].items():
        factor = f"{found['value']:.3g} times the model's"
        if found["low"] is not None:
            factor += f", {found['low']:.3g} to {found['high']:.3g} with 90 %"
        rows.append((f"calibrated {name.replace('_', ' ')}", factor))
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
        print_text(f"warning: {warning}")


def _describe_gram(sensitivity: dict[str, Any] | None, fitness: "Fitness[Any]") -> str:
    """What one gram does to the result at the agent's target, in words."""
    if sensitivity is None:
        return "its effect on a flight is not known"
    errors = sensitivity["errors"][sensitivity["target"]]
    now, lighter, heavier = (
        f"{fitness.measure(100 - errors[case]):.2f}" for case in ("as_simulated", "lighter", "heavier")
    )
    return f"{fitness.heading} for {sensitivity['target']}: {now}; 1 g less {lighter}, 1 g more {heavier}"


def _describe_rest(rest: dict[str, Any]) -> str:
    """How it hangs in still water, or floats on it, in words."""
    pitch = rest["pitch_deg"]
    attitude = f"pitched {pitch:+.1f} deg"
    if abs(pitch) > 89.9:
        attitude = "fore end down" if pitch > 0 else "fore end up"
    where = "turns" if rest["height"] is None else f"floats, its core {-1000 * rest['height']:.1f} mm under,"
    period = rest["slowest_period"]
    swings = "indifferent" if period is None else f"slowest oscillation {period:.3g} s"
    return f"{where} {attitude}; {swings}"
