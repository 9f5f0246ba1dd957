"""``driftform network``: the commands, which call the functions of :mod:`driftform_networks.api`."""

import os
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from driftform.cli import options
from driftform.errors import InputError

Net: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="NET", help="An EPANET file (.inp), or the name of a network that WNTR ships, such as Net3."
    ),
]
Agent: TypeAlias = Annotated[
    str,
    typer.Argument(
        metavar="AGENT",
        help="agent.json, RUN:TARGET or a genome, or a homogeneous sphere such as sphere:60mm.",
    ),
]
Release: TypeAlias = Annotated[
    str, typer.Option(metavar="NODE", help="Node where bodies enter the water, such as a hydrant.")
]
Releases: TypeAlias = Annotated[
    list[str],
    typer.Option(metavar="NODE", help="Node where bodies may enter the water; may be given repeatedly."),
]
At: TypeAlias = Annotated[
    float, typer.Option(metavar="HOURS", min=0, max=1e6, help="Hour of the simulation.")
]
Hours: TypeAlias = Annotated[
    list[float] | None,
    typer.Option(
        metavar="HOURS",
        min=0,
        max=1e6,
        help="Hour at which bodies may enter; may be given repeatedly, by default 0.",
    ),
]
Unsteady: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--unsteady",
        help="Let the flows change after the release, as EPANET computes them; by default they do not.",
    ),
]
Walks: TypeAlias = Annotated[
    int,
    typer.Option(
        metavar="N",
        min=0,
        max=10_000_000,
        help="Bodies that are followed one by one for the distribution of arrival times; 0 for none.",
    ),
]
Seed: TypeAlias = Annotated[int, typer.Option(metavar="N", min=0, max=2**63 - 1, help="Seed of these walks.")]
Buoyancy: TypeAlias = Annotated[
    float | None,
    typer.Option(
        metavar="NEWTONS", help="Net buoyancy to which the core trims the agent; by default as designed."
    ),
]
Buoyancies: TypeAlias = Annotated[
    list[float] | None,
    typer.Option(
        metavar="NEWTONS",
        help="Net buoyancy to which cores trim the agents; may be given repeatedly, by default 0, 0.001 and -0.001.",
    ),
]
Branch: TypeAlias = Annotated[
    str, typer.Option(metavar="SIDE", help="Where branches leave the pipes: top, side or bottom.")
]
ServiceBore: TypeAlias = Annotated[
    float,
    typer.Option(
        metavar="METRES",
        min=0,
        max=10,
        help="Bore of the pipes through which demand leaves, m; narrower bodies leave with it.",
    ),
]
Scenario: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="NAME|FILE", help="Study whose water and wall to use; by default those of water mains."
    ),
]
Map: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE", help="Map to draw, an SVG file; a PNG beside it if the extra png is installed."
    ),
]
Tables: TypeAlias = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Directory for CSV tables, for pandas.")
]
Report: TypeAlias = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Page to write with map, tables and assumptions, an HTML file."),
]
Cache: TypeAlias = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Directory for results that are kept; by default the user's cache."),
]


def show(
    net: Net,
    at: At = 0.0,
    map: Map = None,
    cache: Cache = None,
    json: options.Json = False,
) -> None:
    """Show what a network is: its pipes, flows, sources, loops and reversals."""
    from driftform_networks.show import show_network

    show_network(net, at, map, cache, json)


def tracers(
    net: Net,
    release: Release,
    at: At = 0.0,
    unsteady: Unsteady = False,
    walks: Walks = 2000,
    seed: Seed = 0,
    map: Map = None,
    tables: Tables = None,
    report: Report = None,
    cache: Cache = None,
    json: options.Json = False,
) -> None:
    """Compute where point tracers go, which divide like the water: probability and age at each node.

    The result is that of EPANET's own quality engine; bodies have ways of their own (driftform network route).
    """
    from driftform_networks.api import trace
    from driftform_networks.reading import open_network
    from driftform_networks.results import Outputs, present_passage

    outputs = Outputs(map, tables, report).check()
    network = open_network(net, cache)
    passage = trace(network, release, hour=at, unsteady=unsteady, walks=walks, seed=seed)
    title = f"{network.name}: tracers from {release} at hour {at:g}"
    present_passage(passage, title, outputs, json)


def route(
    net: Net,
    agent: Agent,
    release: Release,
    at: At = 0.0,
    buoyancy: Buoyancy = None,
    branch: Branch = "side",
    service_bore: ServiceBore = 0.02,
    unsteady: Unsteady = False,
    walks: Walks = 2000,
    seed: Seed = 0,
    scenario: Scenario = None,
    settings: options.Settings = None,
    workers: options.Workers = None,
    map: Map = None,
    tables: Tables = None,
    report: Report = None,
    cache: Cache = None,
    json: options.Json = False,
) -> None:
    """Compute where an agent goes: probability and age at each node, what it sees, where it is stuck.

    Flights of the agent in the bores of the network are made first and kept; after an interruption, the same command
    continues.
    """
    from driftform.util import progress
    from driftform_networks import api
    from driftform_networks.bodies import open_traveller
    from driftform_networks.page import BODIES
    from driftform_networks.reading import open_network
    from driftform_networks.results import Outputs, present_passage
    from driftform_networks.travelling import Travel

    outputs = Outputs(map, tables, report).check()
    travel = Travel.parse(branch, service_bore)
    network = open_network(net, cache)
    network.find_node(release)
    traveller = open_traveller(agent, scenario, settings or (), buoyancy)
    with progress.count_progress("flight tables") as shown:
        passage = api.route(
            network,
            traveller,
            release,
            hour=at,
            unsteady=unsteady,
            walks=walks,
            seed=seed,
            travel=travel,
            workers=workers or os.cpu_count() or 1,
            cache=cache,
            progress=shown,
            compare=True,
        )
    title = f"{network.name}: {traveller.name} from {release} at hour {at:g}"
    present_passage(passage, title, outputs, json, BODIES)


def fleet(
    net: Net,
    release: Releases,
    size: Annotated[int, typer.Option(metavar="K", min=1, max=10_000, help="Number of bodies.")] = 10,
    agent: Annotated[
        list[str] | None,
        typer.Option(metavar="AGENT", help="Agent to choose from, as for route; may be given repeatedly."),
    ] = None,
    run: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN", help="Run, such as one of the strategy ribs, whose agents to choose from."
        ),
    ] = None,
    count: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=1000,
            help="Number of agents of the run, by default 4, or of random agents without one, by default 1.",
        ),
    ] = None,
    buoyancy: Buoyancies = None,
    as_designed: Annotated[
        bool,
        typer.Option("--as-designed", help="Leave the agents the cores and the buoyancy of their designs."),
    ] = False,
    at: Hours = None,
    branch: Branch = "side",
    service_bore: ServiceBore = 0.02,
    seed: Annotated[
        int, typer.Option(metavar="N", min=0, max=2**63 - 1, help="Seed of the random agents.")
    ] = 0,
    scenario: Scenario = None,
    settings: options.Settings = None,
    workers: options.Workers = None,
    map: Map = None,
    tables: Tables = None,
    report: Report = None,
    agents: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Directory for the agent.json of each member, to be printed."),
    ] = None,
    cache: Cache = None,
    json: options.Json = False,
) -> None:
    """Choose a fleet: which agents, released where and when, see most of the pipes together.

    Each member is the one that adds most to those before it. The result is beside that of drifters which divide like the
    water, and of bodies that are steered perfectly.
    """
    from driftform.util import progress
    from driftform_networks.candidates import BUOYANCIES, collect_candidates
    from driftform_networks.fleets import plan_fleet
    from driftform_networks.reading import open_network
    from driftform_networks.results import Outputs, present_fleet
    from driftform_networks.travelling import Travel

    if as_designed and buoyancy:
        raise InputError("--as-designed and --buoyancy say different things: leave out one of them")
    outputs = Outputs(map, tables, report, agents).check()
    travel = Travel.parse(branch, service_bore)
    network = open_network(net, cache)
    for name in release:
        network.find_node(name)
    trims = None if as_designed else (buoyancy or BUOYANCIES)
    travellers = collect_candidates(agent or (), run, count, seed, trims, scenario, settings or ())
    with progress.count_progress("flight tables") as shown:
        planned = plan_fleet(
            network,
            travellers,
            release,
            size,
            hours=at or (0.0,),
            travel=travel,
            workers=workers or os.cpu_count() or 1,
            cache=cache,
            progress=shown,
        )
    title = f"{network.name}: a fleet of {size} from {', '.join(dict.fromkeys(release))}"
    present_fleet(planned, title, outputs, json, travellers)


app = typer.Typer(
    help="Follow agents through the water network of a town: where they go, when, and which fleet sees most.",
    no_args_is_help=True,
)
for command in (show, tracers, route, fleet):
    app.command(command.__name__)(command)
