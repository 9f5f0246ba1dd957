"""The regime of the flow in each bore of a pipe: its profile, its Reynolds number, and whether a formula holds there."""

from typing import TYPE_CHECKING

from driftform.util.validity import RANGES, find_departures
from driftform.water.flow import (
    KARMAN,
    DevelopedFlow,
    DevelopedProfile,
    DevelopingFlow,
    Flow,
    PipeFlow,
    PowerLawFlow,
    RoughFlow,
    friction_velocity,
    is_laminar,
)
from driftform.water.parts.profiles import DEVELOPING, GRID, LOG_LAW, PARABOLA, POWER_LAW, UNIFORM
from driftform.water.parts.shapes import Tee

if TYPE_CHECKING:
    from driftform.water.scenario import Scenario


def profile_kind(flow: Flow, radius: float, speed: float, viscosity: float) -> float:
    """Return the profile of a flow in a bore of ``radius`` (m) at the mean ``speed`` (m/s)."""
    match flow:
        case PowerLawFlow():
            return POWER_LAW
        case DevelopingFlow():
            return DEVELOPING
        case RoughFlow():
            return PARABOLA if is_laminar(flow, radius, speed, viscosity) else LOG_LAW
    return GRID if flow.kind == "grid" else UNIFORM


def profile_parameter(flow: Flow, radius: float, speed: float, viscosity: float) -> float:
    """Return the parameter of a profile: 1/n (power law), u* / (kappa U) (log law) or nu / U (developing)."""
    match flow:
        case PowerLawFlow():
            return 1 / flow.exponent
        case RoughFlow():
            # The velocity of water at rest does not depend on its profile.
            speed = max(speed, 1e-12)
            return friction_velocity(flow, radius, speed, viscosity) / (KARMAN * speed)
        case DevelopingFlow():
            return viscosity / flow.speed
    return 0.0


def list_bores(scenario: "Scenario") -> list[tuple[str, float, float]]:
    """Return the key, the radius (m) and the mean speed (m/s) of every bore of a pipe with another flow; not of bends."""
    found: dict[tuple[float, float], str] = {}
    layout, flow = scenario.pipe.layout, scenario.flow
    for placed in layout.parts:
        part, speed = placed.part, flow.speed * placed.flow * (layout.inlet.radius / placed.part.radius) ** 2
        found.setdefault((part.radius, speed), placed.key)
        share = 1 - part.share if isinstance(part, Tee) else 1.0
        found.setdefault((part.end_radius, speed * share * (part.radius / part.end_radius) ** 2), placed.key)
    return [(key, radius, speed) for (radius, speed), key in found.items() if speed > 0]


def warn_of_regime(scenario: "Scenario") -> list[str]:
    """Return where the profile of ``flow.kind`` does not hold, one line each: quantity, value, range and next step."""
    flow = scenario.flow
    found: list[str] = []
    if not isinstance(flow, PipeFlow) or scenario.pipe.is_open:
        return found
    laminar, turbulent = RANGES["laminar profile"][0].high, RANGES["logarithmic law"][0].low
    formula = "power law" if isinstance(flow, PowerLawFlow) else "logarithmic law"
    for key, radius, speed in list_bores(scenario):
        reynolds = 2 * radius * speed / scenario.fluid.viscosity
        place = "the pipe" if scenario.pipe.straight else key
        where = f"flow.kind = '{flow.kind}' in {place} ({2 * radius:.4g} m wide, {speed:.3g} m/s)"
        if laminar <= reynolds < turbulent and isinstance(flow, DevelopedFlow):
            found.append(
                f"{where}: Reynolds number Re_D = {reynolds:.4g}: the profile is unknown from {laminar:g} to "
                f"{turbulent:g}, where the flow is neither laminar nor turbulent; the logarithmic law is taken"
            )
        elif not is_laminar(flow, radius, speed, scenario.fluid.viscosity):
            advice = "; take flow.kind = 'developed', which has the laminar profile" if reynolds < laminar else ""
            found += [f"{where}: {line}{advice}" for line in find_departures(formula, {"Re_D": reynolds})]
    return [*found, *_warn_of_entry(scenario)]


def _warn_of_entry(scenario: "Scenario") -> list[str]:
    """Return a line if the pipe is shorter than the length in which its flow develops from a uniform one."""
    layout, flow = scenario.pipe.layout, scenario.flow
    if not isinstance(flow, DevelopedProfile) or flow.speed <= 0:
        return []
    radius = layout.inlet.radius
    reynolds = 2 * radius * flow.speed / scenario.fluid.viscosity
    laminar = is_laminar(flow, radius, flow.speed, scenario.fluid.viscosity)
    entry = entry_length(reynolds, laminar) * 2 * radius
    length = layout.longest_path + flow.upstream
    if length >= entry:
        return []
    return [
        f"flow.kind = '{flow.kind}': from a uniform inlet the profile develops within {entry:.3g} m (Re_D = {reynolds:.3g}), and "
        f"the pipe is {length:.3g} m long: set flow.upstream to the length of the same bore before the inlet, or take "
        "flow.kind = 'developing'"
    ]


def entry_length(reynolds: float, laminar: bool) -> float:
    """Return the length in which a uniform flow develops, in diameters (White, Fluid Mechanics, eqs. 6.5 and 6.6).

    >>> round(entry_length(1e5, False)), round(entry_length(2000.0, True))
    (30, 120)
    """
    return 0.06 * reynolds if laminar else 4.4 * reynolds ** (1 / 6)
