"""Networks that WNTR ships, and EPANET's own quality engine on flows that no longer change."""

import re
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from driftform_networks.network import Network
from driftform_networks.snapshot import STILL

from driftform.types import FloatArray

GPM, FOOT = 6.30901964e-05, 0.3048


def library(name: str) -> Path:
    """The file of a network that WNTR ships."""
    spec = find_spec("wntr")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parent / "library" / "networks" / f"{name}.inp"


@cache
def read_library(name: str) -> Network:
    from driftform_networks.epanet import run_epanet

    return run_epanet(library(name))


def freeze(name: str, folder: Path, step: int = 0) -> Path:
    """Write the network with the flows of one step for ever: tanks are reservoirs, demands and statuses are constant."""
    network = read_library(name)
    flow, outflow, head = (rows[step] for rows in (network.hydraulics.flow, network.hydraulics.outflow, network.hydraulics.head))
    text = library(name).read_text("latin-1")
    sections = dict(re.findall(r"^\[(\w+)\][^\n]*\n(.*?)(?=^\[|\Z)", text, re.M | re.S))
    kinds = dict(zip(network.nodes, network.node_kinds, strict=True))
    where = {node: index for index, node in enumerate(network.nodes)}
    junctions = [
        f"{n} {network.elevation[where[n]] / FOOT:.12g} {outflow[where[n]] / GPM:.12g}" for n in kinds if kinds[n] == "junction"
    ]
    sources = [f"{n} {head[where[n]] / FOOT:.15g}" for n in kinds if kinds[n] != "junction"]
    patterns = {line.split()[0] for line in sections["PATTERNS"].splitlines() if line.strip() and line.strip()[0] != ";"}
    valves = {line.split()[0] for line in sections["PIPES"].splitlines() if re.search(r"\bCV\b", line.partition(";")[0])}
    closed = [f"{n} CLOSED" for n, q in zip(network.links, flow, strict=True) if abs(q) < 1e-9 and n not in valves]
    moving = [
        f"{n} OPEN"
        for n, k, q in zip(network.links, network.link_kinds, flow, strict=True)
        if k == "pipe" and abs(q) >= 1e-9 and n not in valves
    ]
    written = {
        "JUNCTIONS": "\n".join(junctions),
        "RESERVOIRS": "\n".join(sources),
        **{part: sections[part] for part in ("PIPES", "PUMPS", "VALVES", "CURVES", "COORDINATES")},
        "STATUS": "\n".join(closed + moving),
        "PATTERNS": "\n".join(f"{p} 1" for p in patterns),
        "OPTIONS": "Units GPM\nHeadloss H-W\nTrials 200\nAccuracy 1e-6\nTolerance 1e-6\nQuality None",
        "TIMES": "Duration 0",
        "END": "",
    }
    path = folder / f"{name}.inp"
    path.write_text("".join(f"[{part}]\n{lines}\n" for part, lines in written.items()), "latin-1")
    return path


def simulate_quality(path: Path, quality: str, hours: float, step: float, tolerance: float = 1e-6) -> FloatArray:
    """EPANET's quality at each node after so many hours, in the order of the file: a share in %, or an age in h."""
    from wntr.epanet.toolkit import ENepanet

    text = path.read_text("latin-1").replace("Quality None", f"Quality {quality}")
    text = text.replace("Duration 0", f"Duration {hours}\nHydraulic Timestep {hours}\nQuality Timestep {step / 3600:.9f}")
    text = text.replace("Tolerance 1e-6", f"Tolerance {tolerance}")
    file = path.with_name("quality.inp")
    file.write_text(text, "latin-1")
    engine = ENepanet()
    engine.ENopen(str(file), str(file.with_suffix(".rpt")), str(file.with_suffix(".bin")))
    engine.ENsolveH()
    engine.ENopenQ()
    engine.ENinitQ(0)
    while True:
        engine.ENrunQ()
        values = [engine.ENgetnodevalue(index, 12) for index in range(1, engine.ENgetcount(0) + 1)]
        if engine.ENnextQ() <= 0:
            break
    names = [engine.ENgetnodeid(index) for index in range(1, engine.ENgetcount(0) + 1)]
    engine.ENclose()
    return dict(zip(names, values, strict=True))
