"""What ``driftform trim`` prints about ballast: what is to be done, in words."""

from collections.abc import Callable
from typing import Any, TypeAlias

from driftform_kit.ballast import MATERIALS, NEGLIGIBLE, PUTTY, ball_diameter, name_material
from driftform_kit.trim import Balls

Commands: TypeAlias = Callable[[Balls, float], tuple[str, str]]
"""Writes the commands that export the kit with balls of a density (kg/m3), and trim it then."""

_NO_MOMENT = 1e-9
"""Moment of ballast that counts as zero, kg m: a thousandth of a gram millimetre."""

_NEAR = 5e-5
"""m: ballast lies where it should if it is off by less than this; nobody can lay it more accurately."""


def describe_place(x: float, aft: float) -> str:
    """Return where ``x`` (m) is, from the core's centre and from the aft end."""
    return f"x {1000 * x:+.2f} mm, {1000 * (x - aft):.2f} mm from the aft end"


def describe_remedy(facts: dict[str, Any], commands: Commands) -> list[str]:
    """Return what is to be done by the document of ``driftform trim``, one line each."""
    aft = facts["aft_end"]
    density, mass, x = (facts[f"ballast_{name}"] for name in ("density", "mass", "x"))
    if abs(mass) < NEGLIGIBLE:
        moment = facts["residual_moment"]
        if abs(moment) < _NO_MOMENT:
            return ["no ballast: it weighs what was simulated, and balances there"]
        return [f"no ballast: it weighs what was simulated, its moment is off by {1e6 * moment:+.3g} g mm"]
    if mass < 0:
        foam = facts["buoyancy"]
        return [
            f"too heavy by {-1000 * mass:.3f} g: print the hull {100 * foam['hull_excess']:.1f} % lighter (less infill or flow),",
            f"or add {1e6 * foam['volume']:.3f} cm3 of foam at {describe_place(foam['x'], aft)};",
            "trimmed below is with foam that the water does not feel, else as simulated",
        ]
    lines = [f"ballast: {1000 * mass:.3f} g at {describe_place(x, aft)}"]
    if not facts["pieces"]:
        return [*lines, *_refuse_ballast(facts, density)]
    exact = abs(facts["residual_moment"]) < _NEAR * mass
    lines.append(
        "there is room for it:" if exact else "it cannot lie there; the nearest that there is room for:"
    )
    lines += [f"  {_describe_piece(piece, density, aft)}" for piece in facts["pieces"]]
    for piece in facts["pieces"]:
        if piece["diameter"] is not None:
            ball = piece["mass"] - piece["putty"]
            balls = ", ".join(
                f"{name} {1000 * ball_diameter(ball, d):.1f} mm" for name, d in MATERIALS.items()
            )
            lines.append(f"balls of {1000 * ball:.3f} g: {balls}")
    lines += _describe_holding(facts, commands)
    if not exact:
        lines.append(f"its moment is then off by {1e6 * facts['residual_moment']:+.3g} g mm")
    return lines


def _refuse_ballast(facts: dict[str, Any], density: float) -> list[str]:
    """Why no ballast can be put in, and what to do."""
    lines = _name_misfits(facts)
    if lines:
        return [
            *lines,
            f"no other seat can be printed: {facts['unheld']}",
            "export the kit again without ballast, print it lighter, and trim it without the option ballast",
        ]
    return [
        f"at {density:g} kg/m3 there is no room for it inside that it can be put to: a ball must pass the bore from the joint "
        "at the core, a ring of putty leave half of the bore free, and a filling be 1 mm thick; take something denser or "
        "lighter, or print it heavier",
    ]


def _describe_piece(piece: dict[str, Any], density: float, aft: float) -> str:
    at = f"{1000 * piece['mass']:.3f} g at {describe_place(piece['x'], aft)}"
    if piece["diameter"] is not None:
        name, size = name_material(density), f"{1000 * piece['diameter']:.1f} mm"
        ball = f"{at}: a {name} ball of {size}" if name in MATERIALS else f"{at}: a ball of {size}, {name}"
        return f"{ball}, in {1000 * piece['putty']:.3f} g of epoxy putty" if piece["putty"] else ball
    if piece["ring"] is not None:
        return f"{at}: a ring of epoxy putty on the wall, {1000 * piece['ring']:.1f} mm wide and thick, without a ball"
    return f"{at}: fills the bore from x {1000 * piece['start']:+.1f} to {1000 * piece['end']:+.1f} mm"


def _name_misfits(facts: dict[str, Any]) -> list[str]:
    """The seats of the kit that are for other balls."""
    return [
        f"the seat in the {ball['part']} at {1000 * (ball['x'] - facts['aft_end']):.2f} mm from the aft end is for a ball of "
        f"{1000 * ball['diameter']:.1f} mm, and does not hold this ballast"
        for ball in facts["misfits"]
    ]


def _describe_holding(facts: dict[str, Any], commands: Commands) -> list[str]:
    """How the ballast gets in, and what holds it there."""
    held, lines = facts["held"], _name_misfits(facts)
    if not held:
        unheld, pieces = facts["unheld"], facts["pieces"]
        setting = ";"
        if any(piece["diameter"] is not None for piece in pieces):
            setting = f", and set it in epoxy putty, which counts as ballast with {PUTTY:g} kg/m3;"
        elif any(piece["putty"] for piece in pieces):
            setting = f"; the putty is taken to have {PUTTY:g} kg/m3;"
        return [
            *lines,
            f"put it in through the joint at the core, before the core{setting}",
            "then weigh the print again",
            f"no seat for it can be printed: {unheld}"
            if unheld
            else "a kit can be printed with a seat for it: --kit",
        ]
    lines += [
        _describe_seat(ball, piece, facts["aft_end"])
        for ball, piece in zip(held, facts["pieces"], strict=True)
    ]
    if facts["misfits"] or facts["seat_mass"] >= 1e-5:
        lines += _describe_export(facts, commands)
    return lines


def _describe_seat(ball: dict[str, Any], piece: dict[str, Any], aft: float) -> str:
    way = (
        f"put it in by the joint {1000 * (ball['mouth'] - aft):.1f} mm from the aft end, before that is joined"
        if ball["pause"] is None
        else f"put it in while that is printed, by a pause at {1000 * ball['pause']:.1f} mm"
    )
    return (
        f"{'a seat' if ball['held_by'] == 'seat' else 'the wall'} in the {ball['part']} holds the ball of "
        f"{1000 * piece['mass']:.3f} g: {way}, and fix it with a drop of glue"
    )


def _describe_export(facts: dict[str, Any], commands: Commands) -> list[str]:
    """How to print the seats that hold the ballast."""
    balls = tuple((round(ball["x"], 5), round(ball["diameter"], 5)) for ball in facts["held"])
    changed = [*facts["misfits"], *facts["held"]]
    parts = " and the ".join(dict.fromkeys(ball["part"] for ball in changed if ball["held_by"] == "seat"))
    seat = f"{1000 * facts['seat_mass']:.3f} g of seat"
    if facts["misfits"]:
        seat = f"another seat, {1000 * facts['seat_mass']:+.3f} g"
    weighed = "without the ball"
    if inside := sum(
        piece["mass"]
        for piece, ball in zip(facts["pieces"], facts["held"], strict=True)
        if ball["pause"] is not None
    ):
        weighed = f"take off the {1000 * inside:.3f} g of ballast that is inside"
    export, trim = commands(balls, facts["ballast_density"])
    return [
        f"print the {parts} again with the same flow, and with {seat}, which is counted above:",
        f"  {export}",
        f"then weigh it, {weighed}, and trim again:",
        f"  {trim}",
    ]
