"""``driftform network``: the commands, which call the functions of :mod:`driftform_networks.planning.following`, and their words."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import wraps
from pathlib import Path
from types import SimpleNamespace as Given
from typing import TYPE_CHECKING, Any

import typer

from driftform.cli import formats, options
from driftform.errors import InputError, did_you_mean
from driftform.util import cores, files

if TYPE_CHECKING:
    from driftform_networks.flights.bodies import Traveller
    from driftform_networks.hydraulics.network import Network
    from driftform_networks.output.results import Outputs


app = typer.Typer(
    help="Follow agents through the water network of a town: where they go, when, and which fleet sees most.",
    no_args_is_help=True,
)

_UNITS = {"s": 1 / 3600, "min": 1 / 60, "h": 1.0, "d": 24.0}


def declare(*names: str) -> Callable[[Callable[[Given, "Outputs"], None]], object]:
    """Return a decorator that adds a command with these options: it takes their values by these names, and the files."""

    def add(run: Callable[[Given, "Outputs"], None]) -> object:
        @options.declare(Path(__file__).with_name("options.toml"), *names)
        @wraps(run)
        def command(given: Given) -> None:
            from driftform_networks.output.results import Outputs

            files = ("map", "tables", "report", "agents", "gis", "crs")
            paths: dict[str, Any] = {name: getattr(given, name, None) for name in files}
            page = formats.parse_page(given.style, given.width_mm)
            run(given, Outputs(**paths, page=page, json=given.json).check())

        return app.command(run.__name__)(command)

    return add


CHANGES = ("close", "open", "set_valve")
WATER = ("steady", "within", "walks", "seed")
BODY = ("buoyancy_error", "demand_error", "branch", "service_bore", "clearance", "scenario", "settings", "workers")
CHOICE = ("agents_from", "run", "count", "buoyancies", "as_designed")
SIGHT = ("receiver", "range", "pipes", "by", "weight")
FILES = ("map", "style", "width_mm", "tables", "gis", "crs", "report", "cache", "json")


@declare("net", "at", *CHANGES, "map", "style", "width_mm", "cache", "json")
def show(given: Given, outputs: "Outputs") -> None:
    """Show the pipes, flows, sources, loops and reversals of a network."""
    from driftform_networks.output.show import show_network

    show_network(_open(given), given.at, outputs)


@declare("net", "release", "at", *WATER, *CHANGES, *SIGHT, *FILES)
def tracers(given: Given, outputs: "Outputs") -> None:
    """Compute where point tracers go, which divide like the water: probability and age at each node.

    The result is that of EPANET's own quality engine; bodies take other routes (driftform network route).
    """
    from driftform_networks.output.results import present_passage
    from driftform_networks.planning.following import trace

    network, outputs = _look(given, _open(given), outputs)
    [hour], how = _pick(given, [given.at])
    passage = trace(network, given.release, hour=hour, **how)
    title = f"{network.name}: tracers from {given.release} at hour {hour:g}"
    present_passage(passage, title, outputs)


@declare(
    "net", "release", "port", "sphere_buoyancies", "agents_besides", "at", "steady", "day_within", "walks", "seed", *CHANGES,
    "service_bore", "clearance", "scenario", "settings", "map", "style", "width_mm", "cache", "json",
)  # fmt: skip
def bodies(given: Given, outputs: "Outputs") -> None:
    """Compare bodies: where spheres of each size and weight can go from a node, and where they drag or stop at night.

    Without flights: a body on the wall moves where the drag of the water exceeds the friction there, hour by hour.
    """
    from driftform_networks.flights.bodies import LEAD_DENSITY
    from driftform_networks.flights.travelling import Travel
    from driftform_networks.output.screened import present_bodies
    from driftform_networks.planning.candidates import collect_candidates
    from driftform_networks.planning.screening import LIFT, SIZES_MM, WEIGHTS, screen_bodies

    network = replace(_open(given), service_bore=given.service_bore)
    environment = (given.scenario, given.settings or ())
    weights, agents = given.sphere_buoyancies or WEIGHTS, given.agents_besides or ()
    sizes = (size for size in SIZES_MM if size < given.port and LIFT * size**3 > max(weights))
    spheres = [f"sphere:{size:g}mm" for size in (given.port, *sizes)]
    travellers = collect_candidates(spheres, None, 0, weights, *environment)
    travellers += collect_candidates(agents, None, 0, given.sphere_buoyancies, *environment) if agents else []
    possible = [one for one in travellers if one.agent.mass.mass <= LEAD_DENSITY * one.agent.mass.volume]
    [hour], how = _pick(given, [given.at])
    how |= {"travel": Travel.parse(network, "side", given.clearance)}
    how["within"] = given.day_within and parse_time("--within", given.day_within)
    present_bodies(*screen_bodies(network, possible or travellers, given.release, hour=hour, **how), outputs)


@declare("net", "agent", "release", "at", "buoyancy", *WATER, *CHANGES, *BODY, *SIGHT, *FILES)
def route(given: Given, outputs: "Outputs") -> None:
    """Compute where an agent goes: probability and age at each node, what it sees, where it is stuck.

    Flights of the agent in the bores of the network are made first and kept; after an interruption, the same command
    continues.
    """
    from driftform_networks.flights.bodies import open_traveller
    from driftform_networks.output.results import present_passage
    from driftform_networks.planning import following

    network, outputs = _look(given, _open(given), outputs)
    network.find_node(given.release)
    traveller = open_traveller(given.agent, given.scenario, given.settings or (), given.buoyancy)
    traveller = replace(traveller, error=given.buoyancy_error)
    [hour], how = _pick(given, [given.at])
    passage = following.route(
        network, traveller, given.release, hour=hour, **how, **_travel(given, network), compare=True
    )
    title = f"{network.name}: {traveller.name} from {given.release} at hour {hour:g}"
    present_passage(passage, title, outputs, traveller)


@declare(
    "net", "releases", "size", *CHOICE, "hours_at", "steady", "within", "walks", *CHANGES, *BODY, "seed",
    *SIGHT, "agents", *FILES,
)  # fmt: skip
def fleet(given: Given, outputs: "Outputs") -> None:
    """Choose a fleet: which agents, released where and when, see most of the pipes together.

    Each member adds most to those before it. Its coverage is compared with drifters that divide like the water, and with
    bodies that are steered perfectly.
    """
    from driftform_networks.output.results import present_fleet
    from driftform_networks.planning.candidates import BUOYANCIES
    from driftform_networks.planning.fleets import plan_fleet

    network, outputs = _look(given, _open(given), outputs)
    releases = split_names(given.releases, network)
    travellers = _collect(given, BUOYANCIES)
    hours, how = _pick(given, given.hours_at or [0.0])
    planned = plan_fleet(network, travellers, releases, given.size, hours=hours, **how, **_travel(given, network))
    title = f"{network.name}: a fleet of {given.size} from {', '.join(dict.fromkeys(releases))}"
    present_fleet(planned, title, outputs, travellers)


@declare(
    "net", "plan_releases", "hydrants", "hours", "plan_within", "battery", "plan_size", "nets", "aim", *CHOICE,
    "steady", "walks", *CHANGES, *BODY, "seed", *SIGHT, *FILES,
)  # fmt: skip
def plan(given: Given, outputs: "Outputs") -> None:
    """Plan an inspection: where and at which hour to release bodies, and where to catch them in nets.

    Bodies see until their battery ends or a net catches them. The nets are compared with an upper bound for any choice,
    and with random nets.
    """
    import numpy as np

    from driftform_networks.output.results import present_plan
    from driftform_networks.planning.plans import AIMS, plan_inspection

    if given.aim not in AIMS:
        raise InputError(f"--aim {given.aim}: no such aim{did_you_mean(given.aim, AIMS)}")
    network, outputs = _look(given, _open(given), outputs)
    hydrants = read_names(given.hydrants, network) if given.hydrants else []
    junctions = [network.nodes[node] for node in np.flatnonzero(~network.stores)]
    releases = split_names(given.plan_releases or (), network) or hydrants or junctions
    travellers = _collect(given, (0.0,))
    hours, how = _pick(given, parse_hours(given.hours))
    planned = plan_inspection(
        network,
        travellers,
        releases,
        given.nets,
        places=hydrants,
        hours=hours,
        size=given.plan_size,
        within=parse_time("--within", given.plan_within),
        battery=given.battery and parse_time("--battery", given.battery),
        aim=given.aim,
        **how,
        **_travel(given, network),
    )
    title = f"{network.name}: {given.plan_size} bodies and {len(planned.nets)} nets within {given.plan_within}"
    present_plan(planned, title, outputs, travellers)


def _open(given: Given) -> "Network":
    from driftform_networks.hydraulics.epanet import Changes, open_network

    changes = Changes.parse(given.close or (), given.open or (), given.set_valve or ())
    return open_network(given.net, given.cache, changes)


def _look(given: Given, network: "Network", outputs: "Outputs") -> tuple["Network", "Outputs"]:
    """Return the network with the weights and service pipes, and the outputs with the columns and receivers, that are asked for."""
    from driftform_networks.planning.sights import find_heard, pick_column, read_pipes, read_weights

    network = replace(network, service_bore=getattr(given, "service_bore", None))
    columns = read_pipes(given.pipes, network)
    if given.weight is not None:
        network = replace(network, weight=read_weights(columns, given.weight))
    receivers = [network.find_node(name) for name in split_names(given.receiver or (), network, "--receiver")]
    heard = find_heard(network, receivers, given.range) if receivers else None
    by = {name: pick_column(columns, "--by", name) for name in given.by or ()}
    return network, replace(outputs, columns=by, heard=heard)


def _travel(given: Given, network: "Network") -> dict[str, Any]:
    """Return how bodies travel, and how their flights are made, as parameters."""
    from driftform_networks.flights.travelling import Travel

    travel = Travel.parse(network, given.branch, given.clearance)
    return {
        "travel": travel,
        "demand_error": given.demand_error,
        "workers": given.workers or cores.count_cores(),
        "cache": given.cache,
    }


def _collect(given: Given, buoyancies: Sequence[float]) -> "list[Traveller]":
    """Return the bodies to choose from."""
    from driftform_networks.planning.candidates import collect_candidates

    if given.as_designed and given.buoyancies:
        raise InputError("--as-designed and --buoyancy say different things: leave out one of them")
    trims = None if given.as_designed else (given.buoyancies or buoyancies)
    chosen = (given.agents_from or (), given.run, given.count, trims)
    found = collect_candidates(*chosen, given.scenario, given.settings or ())
    return [replace(one, error=given.buoyancy_error) for one in found]


def _pick(given: Given, hours: Sequence[float]) -> tuple[Sequence[float], dict[str, Any]]:
    """Return the hours of releases, and how bodies are followed, by the names of parameters."""
    within = {} if not hasattr(given, "within") else {"within": given.within and parse_time("--within", given.within)}
    is_steady = given.steady is not None
    return [given.steady] if is_steady else hours, {
        "steady": is_steady,
        "walks": given.walks,
        "seed": given.seed,
        **within,
    }


def parse_time(option: str, text: str) -> float:
    """Return a duration in hours.

    Raises InputError if it is not a duration, or not positive.

    >>> parse_time("--within", "90min"), parse_time("--within", "8h"), parse_time("--within", "8")
    (1.5, 8.0, 8.0)
    """
    found = re.fullmatch(r"(\d+\.?\d*) ?(s|min|h|d)?", text.strip())
    hours = float(found[1]) * _UNITS[found[2] or "h"] if found else 0.0
    if not 0 < hours < 1e6:
        raise InputError(f"{option} {text}: expected a time such as 8h, 90min or 2d")
    return hours


def parse_hours(text: str) -> list[float]:
    """Return hours that ``6-18``, ``6-18/2`` or ``6,12.5`` names, in order.

    Raises InputError if it names none, or more than a thousand.

    >>> parse_hours("6-8,12.5"), parse_hours("0-24/12")
    ([6.0, 7.0, 8.0, 12.5], [0.0, 12.0, 24.0])
    """
    hours = set[float]()
    for part in text.split(","):
        found = re.fullmatch(r" *(\d+\.?\d*)(?:-(\d+\.?\d*)(?:/(\d+\.?\d*))?)? *", part)
        first, last, step = (
            (float(found[i] or (found[1], found[1], 1)[i - 1]) for i in (1, 2, 3)) if found else (0, -1, 1)
        )
        count = (last - first) / step if step > 0 else -1
        if not 0 <= count < 1000:
            raise InputError(f"--hours {text}: expected hours such as 6-18, 6-18/2 or 6,12")
        hours |= {first + step * number for number in range(int(count + 1e-9) + 1)}
    return sorted(hours)


def split_names(texts: Iterable[str], network: "Network", option: str = "--release") -> list[str]:
    """Return the nodes of options, which commas separate, each once. Raises InputError if there is no such node."""
    names = [name.strip() for text in texts for name in ([text] if text in network.nodes else text.split(","))]
    for name in names:
        network.find_node(name, option)
    return list(dict.fromkeys(names))


def read_names(path: Path, network: "Network") -> list[str]:
    """Return the nodes that a text names at the begin of its lines; a first line that names none is a heading.

    Raises InputError if the file cannot be read, or another line names no node.
    """
    found = list[str]()
    for number, line in enumerate(files.read_text(path).splitlines(), 1):
        name = re.split(r"[,;\t]", line)[0].strip().strip('"')
        if not name or name.startswith("#") or (number == 1 and name not in network.nodes):
            continue
        if name not in network.nodes:
            raise InputError(f"{path}: line {number}: {network.name} has no node {name!r}")
        found.append(name)
    if not found:
        raise InputError(f"{path}: names no node of {network.name}: expected one on each line")
    return list(dict.fromkeys(found))
