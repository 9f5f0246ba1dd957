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
from driftform_networks.chain import follow
from driftform_networks.network import Network
from driftform_networks.reading import open_network
from driftform_networks.snapshot import STILL, Snapshot, take_snapshot
from driftform_networks.tracers import route_tracers
from driftform_networks.walkers import walk

pytestmark = pytest.mark.slow

FOLDER = os.environ.get("DRIFTFORM_INP", "")

TEN = ("Net1", "Net3", "ky3", "ky4", "ky5", "ky6", "ky7", "ky10", "BWSN_Network_1", "Balerma", "Anytown", "Richmond_skeleton")  # fmt: skip
"""Networks of the collections, by the names of their files: with tanks, pumps and valves, up to 1158 pipes."""

ASK_EPANET = """
import sys, epanet
project = epanet.EN_createproject()[1]
opened = epanet.EN_open(project, sys.argv[1], sys.argv[2], "")[0]
print("runs" if opened < 100 and epanet.EN_solveH(project)[0] < 100 else "refuses")
epanet.EN_close(project)
"""

TRACE, AGE, DURATION, INITIAL, TANK_DIAMETER, MIXING, FIFO = 3, 2, 0, 4, 17, 15, 2
"""Codes of the EPANET toolkit."""


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


def follow_quality(
    path: Path, quality: int, trace: str, hours: float | None, step: int
) -> tuple[FloatArray, FloatArray]:
    """Times, s, and EPANET's quality at each node, (times, nodes); with ``hours`` alone the last, at the flows of hour 0."""
    import epanet

    project = epanet.EN_createproject()[1]

    def call(name: str, *arguments: object) -> Any:
        code, *found = getattr(epanet, f"EN_{name}")(project, *arguments)
        assert code < 100, f"{name}: error {code}"
        return found[0] if found else None

    call("open", str(path), os.devnull, "")
    tanks = [node for node in range(1, call("getcount", 0) + 1) if call("getnodetype", node) == 2]
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
            call(
                "setnodevalue",
                node,
                TANK_DIAMETER,
                1000 * epanet.EN_getnodevalue(project, node, TANK_DIAMETER)[1],
            )
    for node in range(1, call("getcount", 0) + 1):
        call("setnodevalue", node, INITIAL, 0.0)
    call("settimeparam", 2, step)
    call("setoption", 2, 1e-5)
    call("setqualtype", quality, "", "", trace)
    call("solveH")
    call("openQ")
    call("initQ", 0)
    times, values, left = [], [], 1
    while left > 0:
        times.append(call("runQ"))
        values.append(np.array(call("getnodevalues", 12)))
        left = call("nextQ" if hours is not None else "stepQ")
        if hours is not None:
            del times[:-1], values[:-1]
    call("close")
    epanet.EN_deleteproject(project)
    return np.array(times, float), np.array(values)


def find_source(snapshot: Snapshot) -> int:
    """The reservoir that gives most."""
    network = snapshot.network
    found = [node for node in np.flatnonzero(network.stores) if network.node_kinds[node] == "reservoir"]
    return int(max(found, key=lambda node: snapshot.departure[node]))


def find_file(files: list[Path], name: str) -> Path:
    found = [path for path in files if path.stem.lower() == name.lower()]
    assert found, f"{FOLDER} has no {name}.inp"
    return found[0]


def arriving(network: Network, flow: FloatArray) -> FloatArray:
    nodes = len(network.nodes)
    return np.bincount(network.end, np.maximum(flow, 0), nodes) + np.bincount(
        network.start, np.maximum(-flow, 0), nodes
    )


def test_tracers_are_the_trace_and_the_age_of_epanet(files: list[Path], tmp_path: Path) -> None:
    lines = ["| network | links | TRACE, points | AGE, relative | nodes with AGE |", "|---|---|---|---|---|"]
    aged = 0
    for name in TEN:
        path = find_file(files, name)
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
        _, shares = follow_quality(path, TRACE, network.nodes[source], hours, step)
        expected = shares[-1] * arriving(network, network.hydraulics.flow[0]) / snapshot.departure[source]
        settled = ~network.stores & ~(passage.age > hours * 3600 / 5)
        off = float(np.abs(100 * passage.visits - expected)[settled].max())
        assert off < 0.01, name
        # The age of what tanks give is not that of the pipes, and EPANET's 400 h do not see water of slow links.
        known = ~network.stores & (mean < 12 * 3600) & (mean > 600) & ~find_unknown(snapshot, sources)
        late = "-"
        if known.any():
            _, found = follow_quality(path, AGE, "", 400, 300)
            late = f"{np.abs(3600 * found[-1][known] / mean[known] - 1).max():.1e}"
            assert float(late) < 1e-3, name
            aged += 1
        lines.append(f"| {name} | {len(network.links)} | {off:.4f} | {late} | {known.sum()} |")
        print(lines[-1], flush=True)
    assert aged >= 3


def find_unknown(snapshot: Snapshot, sources: Sequence[int]) -> np.ndarray:
    """Which nodes have water of tanks, or of links that take it longer than 200 h."""
    network = snapshot.network
    unknown = np.zeros(len(network.nodes), bool)
    unknown[[node for node in sources if network.node_kinds[node] == "tank"]] = True
    unknown[snapshot.head[snapshot.duration > 200 * 3600]] = True
    while (more := unknown[snapshot.tail] & ~unknown[snapshot.head]).any():
        unknown[snapshot.head[more]] = True
    return unknown


@pytest.mark.parametrize("name", ["Net1", "Net3", "BWSN_Network_1", "L-TOWN", "Anytown"])
def test_tracers_in_changing_flows_are_the_trace_of_epanet(files: list[Path], name: str, tmp_path: Path) -> None:
    """Of bodies that come with the water of a day, as many pass each node as marked water does."""
    path = find_file(files, name)
    network = open_network(path, tmp_path)
    h, source = network.hydraulics, find_source(take_snapshot(network))
    end = min(h.end, 24 * 3600.0)
    begins = h.times[h.times < end]
    steps = np.diff(np.append(begins, end))
    at, shares = follow_quality(path, TRACE, network.nodes[source], None, 60)
    at, shares = at[at < end], shares[at < end] / 100
    row = np.searchsorted(begins, at + 1e-6, side="right") - 1
    duration = np.diff(np.append(at, end))[:, None]
    middle = (shares + np.vstack([shares[1:], shares[-1:]])) / 2
    come = np.array([arriving(network, flow) for flow in h.flow[: len(begins)]])
    released = np.maximum(-h.outflow[: len(begins), source], 0) * steps
    expected = (middle * come[row] * duration).sum(axis=0) / released.sum()
    rng, count = np.random.default_rng(2), 20_000
    step = rng.choice(len(steps), count, p=released / released.sum())
    began = begins[step] + rng.random(count) * steps[step]
    routings = [route_tracers(take_snapshot(network, time / 3600)) for time in begins]
    found = walk(routings, [*begins, end], source, began, rng)
    visits = np.bincount(found.node[found.node >= 0], minlength=len(network.nodes)) / count
    junctions = ~network.stores
    deviation = np.abs(visits - expected)[junctions]
    # Four standard deviations of the count, and what EPANET's steps of a minute leave.
    allowed = 4 * np.sqrt(np.maximum(expected, 1e-4) / count)[junctions] + 2e-3
    assert (deviation <= allowed).mean() == 1, f"{deviation.max()}"
