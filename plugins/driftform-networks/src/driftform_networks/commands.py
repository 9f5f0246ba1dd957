"""``driftform network``: the commands, which call the functions of :mod:`driftform_networks.api`."""

from pathlib import Path
from typing import Annotated, TypeAlias

from driftform.commands import Argument, CommandGroup, CommandResult, Option

Net: TypeAlias = Annotated[
    str, Argument("NET", "An EPANET file (.inp), or the name of a network that WNTR ships, such as Net3.")
]
Release: TypeAlias = Annotated[
    str, Option("--release", "Node where bodies enter the water, such as a hydrant.", "NODE")
]
At: TypeAlias = Annotated[float, Option("--at", "Hour of the simulation.", "HOURS", 0, 1e6)]
Unsteady: TypeAlias = Annotated[
    bool,
    Option(
        "--unsteady",
        "Let the flows change after the release, as EPANET computes them; by default they do not.",
    ),
]
Walks: TypeAlias = Annotated[
    int,
    Option(
        "--walks",
        "Bodies that are followed one by one for the distribution of arrival times; 0 for none.",
        "N",
        0,
        10_000_000,
    ),
]
Seed: TypeAlias = Annotated[int, Option("--seed", "Seed of these walks.", "N", 0, 2**63 - 1)]
Map: TypeAlias = Annotated[
    Path | None,
    Option("--map", "Map to draw, an SVG file; a PNG beside it if the extra png is installed.", "FILE"),
]
Tables: TypeAlias = Annotated[
    Path | None, Option("--tables", "Directory for tables of nodes, links and ends, for pandas.", "DIR")
]
Cache: TypeAlias = Annotated[
    Path | None, Option("--cache", "Directory for results that are kept; by default the user's cache.", "DIR")
]


def show(net: Net, at: At = 0.0, map: Map = None, cache: Cache = None) -> CommandResult:
    """Show what a network is: its pipes, flows, sources, loops and reversals."""
    from driftform_networks.show import show_network

    return show_network(net, at, map, cache)


def tracers(
    net: Net,
    release: Release,
    at: At = 0.0,
    unsteady: Unsteady = False,
    walks: Walks = 2000,
    seed: Seed = 0,
    map: Map = None,
    tables: Tables = None,
    cache: Cache = None,
) -> CommandResult:
    """Compute where point tracers go, which divide like the water: probability and age at each node.

    The result is that of EPANET's own quality engine; bodies have ways of their own (driftform network route).
    """
    from driftform_networks.api import trace
    from driftform_networks.reading import open_network
    from driftform_networks.results import check_files, present_passage

    check_files(map, tables)
    network = open_network(net, cache)
    passage = trace(network, release, hour=at, unsteady=unsteady, walks=walks, seed=seed)
    return present_passage(passage, f"{network.name}: tracers from {release} at hour {at:g}", map, tables)


group = CommandGroup(
    "Follow agents through the water network of a town: where they go, when, and which fleet sees most.",
    {"show": show, "tracers": tracers},
)
