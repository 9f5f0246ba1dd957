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
from pathlib import Path

import numpy as np
import pytest

from driftform.errors import InputError
from driftform_networks.hydraulics.epanet import open_network
from driftform_networks.hydraulics.network import STILL, take_snapshot
from driftform_networks.passages.passage import follow
from driftform_networks.passages.routing import route_tracers

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

TRACE, AGE, DURATION, INITIAL, TANK_DIAMETER = 3, 2, 0, 4, 17
TRIALS, ACCURACY = 0, 1
"""Codes of the EPANET toolkit."""


@pytest.fixture(scope="module")
def files():
    """The files of the collections, each content once."""
    if not FOLDER:
        pytest.skip("DRIFTFORM_INP names no folder with EPANET files")
    found = {}
    for path in sorted(Path(FOLDER).rglob("*")):
        if path.suffix.lower() == ".inp":
            found.setdefault(hashlib.sha256(path.read_bytes()).hexdigest(), path)
    return list(found.values())


def test_every_file_that_epanet_runs_loads_and_every_other_one_is_one_line(files, tmp_path, publish):
    counts = Counter()
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


def converge(path, folder):
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


def find_quality(epanet, path, quality, trace, hours, step):
    """EPANET's quality at each node after so many hours at the flows of hour 0."""

    def prepare(call):
        for count, delete in ((5, "deletecontrol"), (6, "deleterule")):
            for number in range(call("getcount", count), 0, -1):
                call(delete, number)
        for code in (DURATION, 1, 3, 5):
            call("settimeparam", code, int(hours * 3600))
        for node in range(1, call("getcount", 0) + 1):
            if call("getnodetype", node) == 2:
                # The levels of tanks, and with them all flows, remain.
                call("setnodevalue", node, TANK_DIAMETER, 1000 * call("getnodevalue", node, TANK_DIAMETER))
            call("setnodevalue", node, INITIAL, 0.0)
        call("settimeparam", 2, step)
        call("setoption", 2, 1e-5)
        call("setqualtype", quality, "", "", trace)

    _, _, values = epanet.follow_quality(path, True, prepare)
    return values[-1]


def find_source(snapshot):
    """The reservoir that gives most."""
    network = snapshot.network
    found = [node for node in np.flatnonzero(network.stores) if network.node_kinds[node] == "reservoir"]
    return int(max(found, key=lambda node: snapshot.departure[node]))


def find_file(files, name):
    found = [path for path in files if path.stem == name]
    assert found, f"{FOLDER} has no {name}.inp"
    return found[0]


def arriving(network, flow):
    nodes = len(network.nodes)
    return np.bincount(network.end, np.maximum(flow, 0), nodes) + np.bincount(
        network.start, np.maximum(-flow, 0), nodes
    )


def test_tracers_are_the_trace_and_the_age_of_epanet(files, tmp_path, epanet):
    print("| network | links | TRACE, points | AGE, relative | nodes with AGE |")
    aged = 0
    for name in STEADY:
        path = converge(find_file(files, name), tmp_path)
        network = open_network(path, tmp_path)
        snapshot = take_snapshot(network)
        source, sources = find_source(snapshot), np.flatnonzero(network.hydraulics.outflow[0] < -STILL)
        passages = {int(node): follow([route_tracers(snapshot)], int(node)) for node in sources if len(snapshot.outlets[node])}  # fmt: skip
        passage = passages[source]
        flux = sum(np.where(one.visits > 0, one.visits, 0) * snapshot.departure[node] for node, one in passages.items())
        ages = sum(np.where(one.visits > 0, one.visits * one.age, 0) * snapshot.departure[node] for node, one in passages.items())  # fmt: skip
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = ages / flux
        hours = float(np.clip(3 * np.nanmax(np.where(passage.visits > 1e-4, passage.age, 0)) / 3600, 2, 150))
        step = max(60, int(hours * 3600 / 4000))
        shares = find_quality(epanet, path, TRACE, network.nodes[source], hours, step)
        expected = shares * arriving(network, network.hydraulics.flow[0]) / snapshot.departure[source]
        settled = ~network.stores & ~(passage.age > hours * 3600 / 5)
        off = float(np.abs(100 * passage.visits - expected)[settled].max())
        assert off < 0.01, name
        # The age of what tanks give is not that of the pipes, and EPANET's 400 h do not see water of slow links.
        known = ~network.stores & (mean < 12 * 3600) & (mean > 600) & ~find_unknown(snapshot, sources)
        late = "-"
        if known.any():
            found = find_quality(epanet, path, AGE, "", 400, 300)
            late = f"{np.abs(3600 * found[known] / mean[known] - 1).max():.1e}"
            assert float(late) < 1e-3, name
            aged += 1
        print(f"| {name} | {len(network.links)} | {off:.4f} | {late} | {known.sum()} |", flush=True)
    assert aged >= 12


def find_unknown(snapshot, sources):
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
