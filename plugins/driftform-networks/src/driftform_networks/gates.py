"""What narrows the way of bodies within a link: pumps, valves and meters, and how much of the bore they leave open."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from driftform.types import Body
from driftform_networks.fits import find_obstacle
from driftform_networks.network import Network


@dataclass(frozen=True)
class Gate:
    """What is in links of a kind: its name, opening over bore, turn of the way through it, and the source of these."""

    name: str
    share: float
    turn_deg: float
    reason: str


@cache
def read_gates() -> dict[str, Gate]:
    """Return the gates by the kind of the link, those of ``clearances.toml``."""
    text = Path(__file__).with_name("clearances.toml").read_text(encoding="utf-8")
    return {kind: Gate(**values) for kind, values in tomllib.loads(text).items()}


def find_gate(clearance: Mapping[str, float], body: Body | None, network: Network, link: int) -> tuple[str, str]:
    """Return why a body cannot pass what is in a link, or what it passes; both are empty where nothing narrows the way.

    ``clearance`` has openings that replace the usual ones, by the name of a link or a kind; ``body`` is ``None`` for a point.
    """
    kind, name = network.link_kinds[link], network.links[link]
    gate = read_gates().get(kind, Gate("fitting", 1.0, 0.0, ""))
    share = clearance.get(name, clearance.get(kind, gate.share))
    if share >= 1:
        return "", "" if gate.name == "fitting" else gate.name
    if share <= 0:
        return f"a {gate.name}, which lets no body pass (--clearance)", ""
    # A pump has no bore of its own: that of the widest pipe beside it.
    ends = (network.start[link], network.end[link])
    near = np.isin(network.start, ends) | np.isin(network.end, ends)
    bore = float(network.diameter[link] or network.diameter[near].max())
    obstacle = "" if body is None else find_obstacle(body, bore, share * bore, np.deg2rad(gate.turn_deg))
    if obstacle:
        return f"in a {gate.name}, {obstacle}", ""
    return "", f"{gate.name}, {1000 * share * bore:.0f} of {1000 * bore:.0f} mm open"
