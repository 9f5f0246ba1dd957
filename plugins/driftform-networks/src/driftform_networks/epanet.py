"""EPANET through WNTR: reads a network file and computes its flows. The only module that imports WNTR."""

import hashlib
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from driftform.errors import InputError
from driftform_networks.network import Hydraulics, Network

_DEMAND, _HEAD, _FLOW = 9, 10, 8
"""Codes of the EPANET toolkit: EN_DEMAND and EN_HEAD of a node, EN_FLOW of a link."""

_FOOT = 0.3048


def run_epanet(path: Path) -> Network:
    """Return the network of an EPANET file, with its flows at every hydraulic step.

    EPANET reads a copy of the file in a temporary folder, and leaves nothing behind.

    Raises
    ------
    InputError
        if EPANET refuses the file or cannot solve it; the message holds EPANET's own words.
    """
    text = path.read_bytes()
    with TemporaryDirectory() as name, _quiet():
        # The toolkit takes names in Latin-1 only.
        copy = Path(name) / "network.inp"
        copy.write_bytes(text)
        engine = _open(copy, path)
        try:
            model = _read_model(copy, path)
            hydraulics = _solve(engine, model, path)
        finally:
            engine.ENclose()
    return _make_network(model, hydraulics, path.stem, hashlib.sha256(text).hexdigest())


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep warnings of WNTR from the user: what EPANET warned of is in the result."""
    logger, level = logging.getLogger("wntr"), logging.getLogger("wntr").level
    logger.setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)


def _open(copy: Path, path: Path) -> Any:
    from wntr.epanet.toolkit import ENepanet

    engine = ENepanet()
    report = copy.with_suffix(".rpt")
    try:
        engine.ENopen(str(copy), str(report), str(copy.with_suffix(".bin")))
    except Exception as error:
        # EPANET writes the rest of its report when it closes the file.
        with suppress(Exception):
            engine.ENclose()
        said = _read_errors(report) or [str(error)]
        raise InputError(*(f"{path}: EPANET refuses the file: {line}" for line in said)) from None
    return engine


def _read_errors(report: Path) -> list[str]:
    """Return the errors in EPANET's report, one line each; the line of the file follows some of them."""
    lines = [line.strip() for line in report.read_text("utf-8", errors="replace").splitlines()]
    found = []
    for line, following in zip(lines, [*lines[1:], ""], strict=False):
        if line.startswith("Error ") and not line.startswith("Error 200"):
            is_quote = line.endswith(":") and following
            found.append(f"{line} {' '.join(following.split())}" if is_quote else line)
    return found


def _read_model(copy: Path, path: Path) -> Any:
    from wntr.network import WaterNetworkModel

    try:
        return WaterNetworkModel(str(copy))
    except Exception as error:
        raise InputError(f"{path}: WNTR cannot read the file: {' '.join(str(error).split())}") from None


def _solve(engine: Any, model: Any, path: Path) -> Hydraulics:
    from wntr.epanet.util import FlowUnits

    units = FlowUnits(engine.ENgetflowunits())
    metre = _FOOT if units.is_traditional else 1.0
    nodes = [engine.ENgetnodeindex(name) for name in model.node_name_list]
    links = [engine.ENgetlinkindex(name) for name in model.link_name_list]
    times: list[int] = []
    states: list[tuple[list[float], ...]] = []
    try:
        engine.ENopenH()
        engine.ENinitH(0)
        while True:
            time = engine.ENrunH()
            state = (
                [engine.ENgetlinkvalue(index, _FLOW) * units.factor for index in links],
                [engine.ENgetnodevalue(index, _DEMAND) * units.factor for index in nodes],
                [engine.ENgetnodevalue(index, _HEAD) * metre for index in nodes],
            )
            step = engine.ENnextH()
            # The state at the end of the simulation holds for no time.
            if step > 0 or not times:
                times.append(time)
                states.append(state)
            if step <= 0:
                break
        engine.ENcloseH()
    except Exception as error:
        raise InputError(f"{path}: EPANET cannot solve the network: {error}") from None
    said = tuple(dict.fromkeys(" ".join(line.split()) for line in engine.errcodelist))
    flow, outflow, head = map(np.array, zip(*states, strict=True))
    return Hydraulics(np.array(times, float), float(time), flow, outflow, head, said)


def _make_network(model: Any, hydraulics: Hydraulics, name: str, digest: str) -> Network:
    nodes = {name: index for index, name in enumerate(model.node_name_list)}
    links = [link for _, link in model.links()]
    kinds = [link.link_type.lower() for link in links]
    return Network(
        name,
        digest,
        tuple(nodes),
        tuple(node.node_type.lower() for _, node in model.nodes()),
        # A reservoir has a head, and no elevation of its own.
        np.array(
            [getattr(node, "elevation", getattr(node, "base_head", 0.0)) for _, node in model.nodes()], float
        ),
        np.array([node.coordinates for _, node in model.nodes()], float).reshape(-1, 2),
        tuple(model.link_name_list),
        tuple(kinds),
        np.array([nodes[link.start_node_name] for link in links], np.int64),
        np.array([nodes[link.end_node_name] for link in links], np.int64),
        np.array([link.length if kind == "pipe" else 0.0 for link, kind in zip(links, kinds, strict=True)]),
        np.array([0.0 if kind == "pump" else link.diameter for link, kind in zip(links, kinds, strict=True)]),
        tuple(np.array(link.vertices, float).reshape(-1, 2) for link in links),
        hydraulics,
    )
