"""``driftform network``: the commands, which call the functions of :mod:`driftform_networks.api`."""

from pathlib import Path
from typing import Annotated, TypeAlias

from driftform.commands import Argument, CommandGroup, CommandResult, Option
from driftform.errors import InputError

Net: TypeAlias = Annotated[
    str, Argument("NET", "An EPANET file (.inp), or the name of a network that WNTR ships, such as Net3.")
]
Agent: TypeAlias = Annotated[
    str,
    Argument("AGENT", "agent.json, RUN:TARGET or a genome, or a homogeneous sphere such as sphere:60mm."),
]
Release: TypeAlias = Annotated[
    str, Option("--release", "Node where bodies enter the water, such as a hydrant.", "NODE")
]
Releases: TypeAlias = Annotated[
    list[str], Option("--release", "Node where bodies may enter the water; may be given repeatedly.", "NODE")
]
At: TypeAlias = Annotated[float, Option("--at", "Hour of the simulation.", "HOURS", 0, 1e6)]
Hours: TypeAlias = Annotated[
    list[float] | None,
    Option("--at", "Hour at which bodies may enter; may be given repeatedly, by default 0.", "HOURS", 0, 1e6),
]
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
Buoyancy: TypeAlias = Annotated[
    float | None,
    Option(
        "--buoyancy", "Net buoyancy to which the core trims the agent; by default as designed.", "NEWTONS"
    ),
]
Buoyancies: TypeAlias = Annotated[
    list[float] | None,
    Option(
        "--buoyancy",
        "Net buoyancy to which cores trim the agents; may be given repeatedly, by default 0, 0.001 and -0.001.",
        "NEWTONS",
    ),
]
Branch: TypeAlias = Annotated[
    str, Option("--branch", "Where branches leave the pipes: top, side or bottom.", "SIDE")
]
ServiceBore: TypeAlias = Annotated[
    float,
    Option(
        "--service-bore",
        "Bore of the pipes through which demand leaves, m; narrower bodies leave with it.",
        "METRES",
        0,
        10,
    ),
]
Scenario: TypeAlias = Annotated[
    str | None,
    Option("--scenario", "Study whose water and wall to use; by default those of water mains.", "NAME|FILE"),
]
Settings: TypeAlias = Annotated[
    list[str] | None, Option("--set", "Set an option of the study: KEY=VALUE.", "KEY=VALUE")
]
Workers: TypeAlias = Annotated[
    int | None,
    Option("--workers", "Worker processes; by default one for each processor.", "N", 1, 1024),
]
Map: TypeAlias = Annotated[
    Path | None,
    Option("--map", "Map to draw, an SVG file; a PNG beside it if the extra png is installed.", "FILE"),
]
Tables: TypeAlias = Annotated[Path | None, Option("--tables", "Directory for CSV tables, for pandas.", "DIR")]
Report: TypeAlias = Annotated[
    Path | None, Option("--report", "Page to write with map, tables and assumptions, an HTML file.", "FILE")
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
    report: Report = None,
    cache: Cache = None,
) -> CommandResult:
    """Compute where point tracers go, which divide like the water: probability and age at each node.

    The result is that of EPANET's own quality engine; bodies have ways of their own (driftform network route).
    """
    from driftform_networks.api import trace
    from driftform_networks.reading import open_network
    from driftform_networks.results import Outputs, present_passage

    outputs = Outputs(map, tables, report)
    outputs.check()
    network = open_network(net, cache)
    passage = trace(network, release, hour=at, unsteady=unsteady, walks=walks, seed=seed)
    return present_passage(passage, f"{network.name}: tracers from {release} at hour {at:g}", outputs)


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
    settings: Settings = None,
    workers: Workers = None,
    map: Map = None,
    tables: Tables = None,
    report: Report = None,
    cache: Cache = None,
) -> CommandResult:
    """Compute where an agent goes: probability and age at each node, what it sees, where it is stuck.

    Flights of the agent in the bores of the network are made first and kept; after an interruption, the same command
    continues.
    """
    from driftform.util.progress import count_progress
    from driftform_networks import api
    from driftform_networks.bodies import open_traveller
    from driftform_networks.page import BODIES
    from driftform_networks.reading import open_network
    from driftform_networks.results import Outputs, present_passage
    from driftform_networks.travelling import Travel

    outputs = Outputs(map, tables, report)
    outputs.check()
    travel = Travel.parse(branch, service_bore)
    network = open_network(net, cache)
    network.find_node(release)
    traveller = open_traveller(agent, scenario, settings or (), buoyancy)
    with count_progress("flight tables") as progress:
        passage = api.route(
            network,
            traveller,
            release,
            hour=at,
            unsteady=unsteady,
            walks=walks,
            seed=seed,
            travel=travel,
            workers=_count(workers),
            cache=cache,
            progress=progress,
            compare=True,
        )
    title = f"{network.name}: {traveller.name} from {release} at hour {at:g}"
    return present_passage(passage, title, outputs, BODIES)


def fleet(
    net: Net,
    release: Releases,
    size: Annotated[int, Option("--size", "Number of bodies.", "K", 1, 10_000)] = 10,
    agent: Annotated[
        list[str] | None,
        Option("--agent", "Agent to choose from, as for route; may be given repeatedly.", "AGENT"),
    ] = None,
    run: Annotated[
        Path | None, Option("--run", "Run, such as one of atlas, whose agents to choose from.", "RUN")
    ] = None,
    count: Annotated[
        int | None,
        Option(
            "--count",
            "Number of agents of the run, by default 4, or of random agents without one, by default 1.",
            "N",
            1,
            1000,
        ),
    ] = None,
    buoyancy: Buoyancies = None,
    as_designed: Annotated[
        bool, Option("--as-designed", "Leave the agents the cores and the buoyancy of their designs.")
    ] = False,
    at: Hours = None,
    branch: Branch = "side",
    service_bore: ServiceBore = 0.02,
    seed: Annotated[int, Option("--seed", "Seed of the random agents.", "N", 0, 2**63 - 1)] = 0,
    scenario: Scenario = None,
    settings: Settings = None,
    workers: Workers = None,
    map: Map = None,
    tables: Tables = None,
    report: Report = None,
    agents: Annotated[
        Path | None, Option("--agents", "Directory for the agent.json of each member, to be printed.", "DIR")
    ] = None,
    cache: Cache = None,
) -> CommandResult:
    """Choose a fleet: which agents, released where and when, see most of the pipes together.

    Each member is the one that adds most to those before it. The result is beside that of drifters which divide like the
    water, and of bodies that are steered perfectly.
    """
    from driftform.util.progress import count_progress
    from driftform_networks.candidates import BUOYANCIES, collect_candidates
    from driftform_networks.fleets import plan_fleet
    from driftform_networks.reading import open_network
    from driftform_networks.results import Outputs, present_fleet
    from driftform_networks.travelling import Travel

    if as_designed and buoyancy:
        raise InputError("--as-designed and --buoyancy say different things: leave out one of them")
    outputs = Outputs(map, tables, report, agents)
    outputs.check()
    travel = Travel.parse(branch, service_bore)
    network = open_network(net, cache)
    for name in release:
        network.find_node(name)
    trims = None if as_designed else (buoyancy or BUOYANCIES)
    travellers = collect_candidates(agent or (), run, count, seed, trims, scenario, settings or ())
    with count_progress("flight tables") as progress:
        planned = plan_fleet(
            network,
            travellers,
            release,
            size,
            hours=at or (0.0,),
            travel=travel,
            workers=_count(workers),
            cache=cache,
            progress=progress,
        )
    title = f"{network.name}: a fleet of {size} from {', '.join(dict.fromkeys(release))}"
    return present_fleet(planned, title, outputs, travellers)


def _count(workers: int | None) -> int:
    import os

    return workers or os.cpu_count() or 1


group = CommandGroup(
    "Follow agents through the water network of a town: where they go, when, and which fleet sees most.",
    {"show": show, "tracers": tracers, "route": route, "fleet": fleet},
)
