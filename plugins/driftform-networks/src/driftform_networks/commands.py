"""``driftform network``: the commands, which call the functions of :mod:`driftform_networks.api`."""

import os
import tomllib
from collections.abc import Callable
from functools import cache
from inspect import Parameter, Signature
from pathlib import Path
from types import SimpleNamespace as Given
from typing import Annotated, Any

import typer

from driftform.cli import options
from driftform.errors import InputError

_SHARED = {"settings": options.Settings, "workers": options.Workers, "json": options.Json}
_TYPES: dict[str, Any] = {
    "argument": str,
    "text": str,
    "texts": list[str],
    "path": Path,
    "number": float,
    "signed": float,
    "numbers": list[float],
    "count": int,
    "switch": bool,
}

app = typer.Typer(
    help="Follow agents through the water network of a town: where they go, when, and which fleet sees most.",
    no_args_is_help=True,
)


@cache
def _read_options() -> dict[str, dict[str, Any]]:
    return tomllib.loads(Path(__file__).with_name("options.toml").read_text(encoding="utf-8"))


def declare_option(name: str) -> Parameter:
    """Return the parameter of an option of ``options.toml``, or of one that commands of driftform share."""
    default: Any = False if name == "json" else None
    if name in _SHARED:
        return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=_SHARED[name])
    option = _read_options()[name]
    kind, flag = option["type"], option.get("flag", f"--{name.replace('_', '-')}")
    shown: dict[str, Any] = {"help": option["help"]} | (
        {} if kind == "switch" else {"metavar": option["metavar"]}
    )
    if kind in ("number", "numbers", "count") and "signed" not in option:
        shown |= {"min": option.get("min", 0), "max": option["max"]}
    default = option.get("default", False if kind == "switch" else None)
    is_required = kind == "argument" or option.get("required") or (kind == "text" and default is None)
    if is_required and not option.get("optional"):
        default = Parameter.empty
    taken = _TYPES[kind] if default is not None else _TYPES[kind] | None
    declared = typer.Argument(**shown) if kind == "argument" else typer.Option(flag, **shown)
    return Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[taken, declared])


def declare(*names: str) -> Callable[[Callable[[Given], None]], Callable[[Given], None]]:
    """Return a decorator that adds a command with these options; it takes their values by these names."""

    def add(run: Callable[[Given], None]) -> Callable[[Given], None]:
        def command(**values: Any) -> None:
            run(Given(**values))

        command.__doc__ = run.__doc__
        command.__signature__ = Signature([declare_option(name) for name in names])  # type: ignore[attr-defined]
        app.command(run.__name__)(command)
        return run

    return add


WATER = ("at", "unsteady", "walks", "seed")
BODY = ("branch", "service_bore", "clearance", "scenario", "settings", "workers")
FILES = ("map", "tables", "report", "cache", "json")


@declare("net", "at", "map", "cache", "json")
def show(given: Given) -> None:
    """Show what a network is: its pipes, flows, sources, loops and reversals."""
    from driftform_networks.show import show_network

    show_network(given.net, given.at, given.map, given.cache, given.json)


@declare("net", "release", *WATER, *FILES)
def tracers(given: Given) -> None:
    """Compute where point tracers go, which divide like the water: probability and age at each node.

    The result is that of EPANET's own quality engine; bodies have ways of their own (driftform network route).
    """
    from driftform_networks.api import trace
    from driftform_networks.reading import open_network
    from driftform_networks.results import Outputs, present_passage

    outputs = Outputs(given.map, given.tables, given.report).check()
    network = open_network(given.net, given.cache)
    passage = trace(network, given.release, **_pick(given, *WATER))
    title = f"{network.name}: tracers from {given.release} at hour {given.at:g}"
    present_passage(passage, title, outputs, given.json)


@declare("net", "agent", "release", "at", "buoyancy", *WATER[1:], *BODY, *FILES)
def route(given: Given) -> None:
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

    outputs = Outputs(given.map, given.tables, given.report).check()
    network = open_network(given.net, given.cache)
    travel = Travel.parse(network, given.branch, given.service_bore, given.clearance)
    network.find_node(given.release)
    traveller = open_traveller(given.agent, given.scenario, given.settings or (), given.buoyancy)
    with progress.count_progress("flight tables") as shown:
        passage = api.route(
            network,
            traveller,
            given.release,
            **_pick(given, *WATER),
            travel=travel,
            workers=given.workers or os.cpu_count() or 1,
            cache=given.cache,
            progress=shown,
            compare=True,
        )
    title = f"{network.name}: {traveller.name} from {given.release} at hour {given.at:g}"
    present_passage(passage, title, outputs, given.json, BODIES)


CHOICE = ("agents_from", "run", "count", "buoyancies", "as_designed")


@declare("net", "releases", "size", *CHOICE, "hours_at", *BODY, "agents_seed", "agents", *FILES)
def fleet(given: Given) -> None:
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

    if given.as_designed and given.buoyancies:
        raise InputError("--as-designed and --buoyancy say different things: leave out one of them")
    outputs = Outputs(given.map, given.tables, given.report, given.agents).check()
    network = open_network(given.net, given.cache)
    travel = Travel.parse(network, given.branch, given.service_bore, given.clearance)
    releases = [name for text in given.releases for name in text.split(",")]
    for name in releases:
        network.find_node(name)
    trims = None if given.as_designed else (given.buoyancies or BUOYANCIES)
    chosen = (given.agents_from or (), given.run, given.count, given.agents_seed, trims)
    travellers = collect_candidates(*chosen, given.scenario, given.settings or ())
    with progress.count_progress("flight tables") as shown:
        planned = plan_fleet(
            network,
            travellers,
            releases,
            given.size,
            hours=given.hours_at or (0.0,),
            travel=travel,
            workers=given.workers or os.cpu_count() or 1,
            cache=given.cache,
            progress=shown,
        )
    title = f"{network.name}: a fleet of {given.size} from {', '.join(dict.fromkeys(releases))}"
    present_fleet(planned, title, outputs, given.json, travellers)


def _pick(given: Given, *names: str) -> dict[str, Any]:
    """Return values by the names of parameters in :mod:`driftform_networks.api`."""
    return {"hour" if name == "at" else name: getattr(given, name) for name in names}
