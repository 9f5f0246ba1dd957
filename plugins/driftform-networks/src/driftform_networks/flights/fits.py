"""Whether a body fits through a bore, around a corner, and through what narrows a link: pumps, valves and meters."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from driftform.types import Body, FloatArray
from driftform_networks.hydraulics.network import Network

_MIN_TURN = np.deg2rad(1.0)


def longest_rod(first: float, second: float, turn: float, width: float) -> float:
    """Return the length of the longest rod that passes a sharp corner between two bores, m.

    The rod lies in the plane of the corner, touches the outer walls of both bores with its ends and the inner edge with
    its side: of all its attitudes, the shortest such line decides (the problem of the ladder, for a ladder of some
    width). A rounded corner lets longer rods pass.

    Args:
        first, second: diameters of the bores, m.
        turn: angle between them, rad, from 0 to less than pi; there is no limit without a turn.
        width: diameter of the rod, m.

    >>> round(longest_rod(1.0, 1.0, np.pi / 2, 0.0), 6)
    2.828427
    """
    if width >= min(first, second):
        return 0.0
    if turn < _MIN_TURN:
        return float("inf")
    inner = np.pi - turn
    # Outer walls along these unit vectors from the outer corner; the inner edge is as far from each as the bores are wide.
    one, two = np.array([1.0, 0.0]), np.array([np.cos(inner), np.sin(inner)])
    edge = np.array([(second + first * np.cos(inner)) / np.sin(inner), first])

    # Normals of the rod point from the outer corner towards the inner edge.
    angles: FloatArray = np.linspace(inner - np.pi / 2, np.pi / 2, 4003)[1:-1]
    normals = np.column_stack([np.cos(angles), np.sin(angles)])
    distance = np.maximum(normals @ edge - width, 0.0)[:, None]
    spans = distance / (normals @ one)[:, None] * one - distance / (normals @ two)[:, None] * two
    return float(np.linalg.norm(spans, axis=1).min())


def find_obstacle(body: Body, first: float, second: float, turn: float) -> str:
    """Return why a body cannot pass from a bore into another, in a few words; empty if it can, or a bore is unknown."""
    if not second:
        return ""
    if body.max_diameter > second:
        return f"too wide: {1000 * body.max_diameter:.0f} mm in a bore of {1000 * second:.0f} mm"
    # What passes with a ball around it needs no search for the attitude.
    is_short = np.hypot(body.length, body.max_diameter) <= min(first, second)
    longest = longest_rod(first, second, turn, body.max_diameter) if first and not is_short else float("inf")
    if body.length > longest:
        return (
            f"too long: {1000 * body.length:.0f} mm, and a turn of {np.rad2deg(turn):.0f} degrees from a bore of "
            f"{1000 * first:.0f} into {1000 * second:.0f} mm lets {1000 * longest:.0f} mm pass"
        )
    return ""


@dataclass(frozen=True)
class Gate:
    """What is in links of a kind: its name, opening over bore, turn of the path through it, and the source of these."""

    name: str
    share: float
    turn_deg: float
    reason: str


@cache
def read_gates() -> dict[str, Gate]:
    """Return the gates by the kind of the link, those of ``clearances.toml``."""
    text = Path(__file__).with_name("clearances.toml").read_text(encoding="utf-8")
    return {kind: Gate(**values) for kind, values in tomllib.loads(text).items()}


def find_gate(clearance: Mapping[str, float], body: Body | None, network: Network, link: int) -> tuple[str, str, float]:
    """Return why a body cannot pass what is in a link, or what it passes, both empty where nothing narrows the bore, and its opening, m.

    ``clearance`` has openings that replace the usual ones, by the name of a link or a kind; ``body`` is ``None`` for a point.
    """
    kind, name = network.link_kinds[link], network.links[link]
    gate = read_gates().get(kind, Gate("fitting", 1.0, 0.0, ""))
    share = clearance.get(name, clearance.get(kind, gate.share))
    if share >= 1:
        return "", "" if gate.name == "fitting" else gate.name, np.inf
    if share <= 0:
        behind = f" (release behind it, at {network.nodes[network.end[link]]})" if kind == "pump" else ""
        return f"before a {gate.name} that lets no body pass{behind}", "", 0.0
    # A pump has no bore of its own: take the widest pipe at its ends.
    ends = (network.start[link], network.end[link])
    near = np.isin(network.start, ends) | np.isin(network.end, ends)
    bore = float(network.diameter[link] or network.diameter[near].max())
    obstacle = "" if body is None else find_obstacle(body, bore, share * bore, np.deg2rad(gate.turn_deg))
    if obstacle:
        return f"in a {gate.name}, {obstacle}", "", share * bore
    return "", f"{gate.name}, {1000 * share * bore:.0f} of {1000 * bore:.0f} mm open", share * bore
