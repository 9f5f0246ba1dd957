"""Public collections of EPANET files: what loads, and tracers against EPANET's own quality engine.

By hand, with the .inp files of some repositories below a folder, each repository in a folder of its own:
``DRIFTFORM_INP=FOLDER pytest -m slow -s plugins/driftform-networks/tests/test_collections.py``; with ``UPDATE_DOCS=1`` the
table goes into docs/networks.md.
"""

import hashlib
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.hydraulics.network import Network
from driftform_networks.hydraulics.snapshot import STILL, Snapshot, take_snapshot
from driftform_networks.passages.chain import follow
from driftform_networks.passages.routing import route_tracers
from driftform_networks.passages.walkers import walk

pytestmark = pytest.mark.slow

FOLDER = os.environ.get("DRIFTFORM_INP", "")

STEADY = (
    *("Net1", "Net3", "ky3", "ky4", "ky5", "ky6", "ky7", "ky10", "BWSN_Network_1"),
    *("Balerma", "Anytown", "Richmond_skeleton", "L-TOWN", "PES", "ZJ"),
)
"""Networks of the collections, by the names of their files: with tanks, pumps and valves, up to 1158 pipes."""

ASK_EPANET = """
import sys, epanet
project = epanet.EN_createproject()[1]
opened = epanet.EN_open(project, sys.argv[1], sys.argv[2], "")[0]
print("runs" if opened < 100 and epanet.EN_solveH(project)[0] < 100 else "refuses")
epanet.EN_close(project)
"""

CHANGING = ("Net1", "Net3", "Anytown", "BWSN_Network_1", "L-TOWN")
"""Networks whose tanks hold the marked water of a day: where they turn over faster, it comes out again."""

BATCHES = 10
"""Bodies are followed in so many batches, whose differences are the standard error."""

CHEMICAL, TRACE, AGE, DURATION, INITIAL, TANK_DIAMETER, MIXING, FIFO, SOURCE = 1, 3, 2, 0, 4, 17, 15, 2, 5
TRIALS, ACCURACY = 0, 1
"""Codes of the EPANET toolkit."""

DECAY = 1e-5
"""Rate of a mark that decays in changing flows, 1/s: the logarithm of what is left is the mean age times this rate."""


@pytest.fixture(scope="module")
def files() -> list[Path]:
    """The files of the collections, each content once."""
    if not FOLDER:
        pytest.skip("DRIFTFORM_INP names no folder with EPANET files")
    found: dict[str, Path] = {}
    for path in sorted(Path(FOLDER).rglob("*")):
        if path.suffix.lower() == ".inp":
            found.setdefault(hashlib.sha256(path.read_bytes()).hexdigest(), path)
    return list(found.values())


def test_every_file_that_epanet_runs_loads_and_every_other_one_is_one_line(
    files: list[Path], tmp_path: Path, publish: Callable[[str, Sequence[str]], None]
) -> None:
    counts: Counter[tuple[str, str]] = Counter()
    for path in files:
        command = [sys.executable, "-c", ASK_EPANET, str(path), str(tmp_path / "report")]
        asked = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, cwd=tmp_path)
        epanet = asked.stdout.strip() if asked.returncode == 0 else "breaks down"
        try:
            network = open_network(path, tmp_path)
            outcome = "loads"
            assert np.isfinite(network.hydraulics.flow).all(), path
        except InputError as error:
            outcome = "one line"
            assert len(error.args) == 1 and "\n" not in str(error), path
        assert outcome == "loads" or epanet != "runs", f"{path}: EPANET runs it"
        counts[epanet, outcome] += 1
    lines = ["| EPANET | driftform | files |", "|---|---|---|"]
    lines += [f"| {epanet} | {outcome} | {count} |" for (epanet, outcome), count in sorted(counts.items())]
    publish("collections", lines)


def converge(path: Path, folder: Path) -> Path:
    """Return a copy of a file whose flows EPANET finds to 1e-8: with a loose `ACCURACY` they depend on where it begins."""
    import epanet

    project, copy = epanet.EN_createproject()[1], folder / path.name
    calls = [
        ("open", str(path), os.devnull, ""),
        ("setoption", ACCURACY, 1e-8),
        ("setoption", TRIALS, 1000),
        ("saveinpfile", str(copy)),
    ]
    for name, *arguments in calls:
        assert getattr(epanet, f"EN_{name}")(project, *arguments)[0] < 100, name
    epanet.EN_deleteproject(project)
    return copy


def follow_quality(
    epanet: Any, path: Path, quality: int, trace: str, hours: float | None, step: int
) -> tuple[FloatArray, FloatArray]:
    """Times, s, and EPANET's quality at each node, (times, nodes); with ``hours`` alone the last, at the flows of hour 0.

    A chemical comes from the node ``trace`` at 100, and decays in pipes.
    """

    def prepare(call: Callable[..., Any]) -> None:
        nodes, links = (range(1, call("getcount", kind) + 1) for kind in (0, 2))
        tanks = [node for node in nodes if call("getnodetype", node) == 2]
        if hours is None:
            for node in tanks:
                # Marked water that comes in leaves last, so that tanks end its way within a day.
                call("setnodevalue", node, MIXING, FIFO)
        else:
            for count, delete in ((5, "deletecontrol"), (6, "deleterule")):
                for number in range(call("getcount", count), 0, -1):
                    call(delete, number)
            for code in (DURATION, 1, 3, 5):
                call("settimeparam", code, int(hours * 3600))
            for node in tanks:
                # Their levels, and with them all flows, remain.
                call("setnodevalue", node, TANK_DIAMETER, 1000 * call("getnodevalue", node, TANK_DIAMETER))
        for node in nodes:
            call("setnodevalue", node, INITIAL, 0.0)
        call("settimeparam", 2, step)
        call("setoption", 2, 1e-5)
        call("setqualtype", quality, "", "", trace)
        if quality == CHEMICAL:
            # Of the first order in the bulk, without a limit or a reaction at the wall; no other node gives any.
            for option, value in ((19, 1.0), (22, 0.0)):
                call("setoption", option, value)
            for link in links:
                for code, value in ((6, -DECAY * 86400), (7, 0.0)) if call("getlinktype", link) < 2 else ():
                    call("setlinkvalue", link, code, value)
            for node in nodes:
                call("setnodevalue", node, SOURCE, 0.0)
            call("setnodevalue", call("getnodeindex", trace), INITIAL, 100.0)

    _, times, values = epanet.follow_quality(epanet, path, hours is not None, prepare)
    return times, values


def find_source(snapshot: Snapshot) -> int:
    """The reservoir that gives most."""
    network = snapshot.network
    found = [node for node in np.flatnonzero(network.stores) if network.node_kinds[node] == "reservoir"]
    return int(max(found, key=lambda node: snapshot.departure[node]))


def find_file(files: list[Path], name: str) -> Path:
    found = [path for path in files if path.stem == name]
    assert found, f"{FOLDER} has no {name}.inp"
    return found[0]


def arriving(network: Network, flow: FloatArray) -> FloatArray:
    nodes = len(network.nodes)
    return np.bincount(network.end, np.maximum(flow, 0), nodes) + np.bincount(
        network.start, np.maximum(-flow, 0), nodes
    )


def test_tracers_are_the_trace_and_the_age_of_epanet(files: list[Path], tmp_path: Path, epanet: Any) -> None:
    print("| network | links | TRACE, points | AGE, relative | nodes with AGE |")
    aged = 0
    for name in STEADY:
        path = converge(find_file(files, name), tmp_path)
        network = open_network(path, tmp_path)
        snapshot = take_snapshot(network)
        source, sources = find_source(snapshot), np.flatnonzero(network.hydraulics.outflow[0] < -STILL)
        passages = {int(node): follow(route_tracers(snapshot), int(node)) for node in sources if len(snapshot.outlets[node])}  # fmt: skip
        passage = passages[source]
        flux = sum(np.where(one.visits > 0, one.visits, 0) * snapshot.departure[node] for node, one in passages.items())
        ages = sum(np.where(one.visits > 0, one.visits * one.age, 0) * snapshot.departure[node] for node, one in passages.items())  # fmt: skip
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = ages / flux
        hours = float(np.clip(3 * np.nanmax(np.where(passage.visits > 1e-4, passage.age, 0)) / 3600, 2, 150))
        step = max(60, int(hours * 3600 / 4000))
        _, shares = follow_quality(epanet, path, TRACE, network.nodes[source], hours, step)
        expected = shares[-1] * arriving(network, network.hydraulics.flow[0]) / snapshot.departure[source]
        settled = ~network.stores & ~(passage.age > hours * 3600 / 5)
        off = float(np.abs(100 * passage.visits - expected)[settled].max())
        assert off < 0.01, name
        # The age of what tanks give is not that of the pipes, and EPANET's 400 h do not see water of slow links.
        known = ~network.stores & (mean < 12 * 3600) & (mean > 600) & ~find_unknown(snapshot, sources)
        late = "-"
        if known.any():
            _, found = follow_quality(epanet, path, AGE, "", 400, 300)
            late = f"{np.abs(3600 * found[-1][known] / mean[known] - 1).max():.1e}"
            assert float(late) < 1e-3, name
            aged += 1
        print(f"| {name} | {len(network.links)} | {off:.4f} | {late} | {known.sum()} |", flush=True)
    assert aged >= 12


def find_unknown(snapshot: Snapshot, sources: Sequence[int]) -> np.ndarray:
    """Which nodes have water of tanks, of links that take it longer than 200 h, or of check valves.

    EPANET counts the time in pipes alone (`reactpipes` of its qualreact.c): water in a pipe with a check valve does not age.
    """
    network = snapshot.network
    unknown = np.zeros(len(network.nodes), bool)
    unknown[[node for node in sources if network.node_kinds[node] == "tank"]] = True
    unknown[snapshot.head[snapshot.duration > 200 * 3600]] = True
    unknown[snapshot.head[np.array(network.link_kinds)[snapshot.links] == "cv"]] = True
    while (more := unknown[snapshot.tail] & ~unknown[snapshot.head]).any():
        unknown[snapshot.head[more]] = True
    return unknown


def test_tracers_in_changing_flows_are_the_trace_and_the_age_of_epanet(
    files: list[Path], tmp_path: Path, epanet: Any
) -> None:
    print("| network | steps of a day | TRACE, points | standard error | AGE, relative | standard error | nodes |")
    for name in CHANGING:
        steps, nodes, *parts = compare_changing(epanet, find_file(files, name), tmp_path)
        (points, error), (late, spread) = ((float(np.abs(part.mean()) * factor), float(off * factor)) for part, off, factor in parts)  # fmt: skip
        print(f"| {name} | {steps} | {points:.3f} | {error:.3f} | {late:.1e} | {spread:.1e} | {nodes} |", flush=True)
        # Three standard errors of the mean over the nodes, which nearly the same bodies pass.
        assert points < 0.01 + 3 * error and late < 1e-3 + 3 * spread, name


def compare_changing(epanet: Any, path: Path, folder: Path) -> tuple[int, int, Any, Any]:
    """Bodies that come with the water of a day: as many pass each node as marked water does, and with the same mean age.

    Returns:
        steps, nodes, trace, age: number of hydraulic steps, and of the nodes that a hundredth of the water passes, ten
            minutes after it came or later; and deviations at these nodes with the standard error of their mean, and a
            factor: of the share of the bodies that pass, and of their age, relative.
    """
    network = open_network(path, folder)
    h, source = network.hydraulics, find_source(take_snapshot(network))
    end = min(h.end, 24 * 3600.0)
    begins = h.times[h.times < end]
    steps = np.diff(np.append(begins, end))
    come = np.array([arriving(network, flow) for flow in h.flow[: len(begins)]])
    released = np.maximum(-h.outflow[: len(begins), source], 0) * steps
    expected = []
    for quality in (TRACE, CHEMICAL):
        at, shares = follow_quality(epanet, path, quality, network.nodes[source], None, 60)
        at, shares = at[at < end], shares[at < end] / 100
        row = np.searchsorted(begins, at + 1e-6, side="right") - 1
        middle = (shares + np.vstack([shares[1:], shares[-1:]])) / 2
        expected.append((middle * come[row] * np.diff(np.append(at, end))[:, None]).sum(axis=0) / released.sum())
    rng, count = np.random.default_rng(2), 20_000
    routings = [route_tracers(take_snapshot(network, time / 3600)) for time in begins]
    with np.errstate(invalid="ignore", divide="ignore"):
        ages = -np.log(expected[1] / expected[0])
    passed = ~network.stores & (expected[0] > 0.01) & (ages > 600 * DECAY)
    found = []
    for _ in range(BATCHES):
        step = rng.choice(len(steps), count, p=released / released.sum())
        began = begins[step] + rng.random(count) * steps[step]
        walks = walk(routings, [*begins, end], source, began, rng)
        arrived = walks.node >= 0
        left = np.exp(-DECAY * (walks.reached - walks.began[walks.walk]))[arrived]
        nodes = walks.node[arrived]
        found.append([np.bincount(nodes, weight, len(passed))[passed] / count for weight in (None, left)])
    visits, left = np.array(found).transpose(1, 0, 2)
    trace = visits - expected[0][passed]
    # The age of all batches together, and its change with the share of each.
    whole, rest, age = visits.mean(axis=0), left.mean(axis=0), ages[passed]
    late = -np.log(rest / whole) / age - 1
    off = (left / rest - visits / whole) / age
    errors = [float(part.mean(axis=1).std(ddof=1) / np.sqrt(BATCHES)) for part in (trace, off)]
    return len(begins), int(passed.sum()), (trace, errors[0], 100.0), (late, errors[1], 1.0)
