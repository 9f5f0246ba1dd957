"""Networks of EPANET and WNTR, and EPANET's own quality engine on flows that no longer change."""

import os
import re
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from shared import shared_folder

FORK = Path(__file__).with_name("fork.inp").read_text()
"""A main that divides: two thirds of the water go on, and a third into a branch of the same bore."""

GPM, FOOT = 6.30901964e-05, 0.3048
_QUALITY = 12
"""Code of the EPANET toolkit: EN_QUALITY of a node."""


def find_library_file(name):
    """The file of a network that driftform or WNTR ships."""
    import driftform_networks

    if (own := Path(driftform_networks.__file__).parent / "hydraulics" / "examples" / f"{name}.inp").is_file():
        return own
    spec = find_spec("wntr")
    return Path(spec.origin).parent / "library" / "networks" / f"{name}.inp"


@cache
def read_library(name):
    from driftform_networks.hydraulics.epanet import open_network

    return open_network(find_library_file(name))


def read_sections(name):
    """The lines of each section of a network that driftform or WNTR ships."""
    text = find_library_file(name).read_text("latin-1")
    return dict(re.findall(r"^\[(\w+)\][^\n]*\n(.*?)(?=^\[|\Z)", text, re.MULTILINE | re.DOTALL))


def list_rows(section):
    """The words of each line of a section, without comments."""
    return [words for line in section.splitlines() if (words := line.partition(";")[0].split())]


def write_sections(path, sections):
    path.write_text("".join(f"[{part}]\n{lines}\n" for part, lines in sections.items()), "latin-1")
    return path


def freeze(name, folder):
    """Write a network with the flows of hour 0 for ever: tanks are reservoirs, demands and statuses are constant."""
    network, sections = read_library(name), read_sections(name)
    flow, outflow, head = (
        rows[0] for rows in (network.hydraulics.flow, network.hydraulics.outflow, network.hydraulics.head)
    )
    kinds, valves = network.node_kinds, {row[0] for row in list_rows(sections["PIPES"]) if "CV" in row}
    junctions = [
        f"{node} {network.elevation[i] / FOOT:.12g} {outflow[i] / GPM:.12g}"
        for i, node in enumerate(network.nodes)
        if kinds[i] == "junction"
    ]
    sources = [f"{node} {head[i] / FOOT:.15g}" for i, node in enumerate(network.nodes) if kinds[i] != "junction"]
    states = [
        f"{link} {'CLOSED' if abs(flow[i]) < 1e-9 else 'OPEN'}"
        for i, link in enumerate(network.links)
        if link not in valves and (abs(flow[i]) < 1e-9 or network.link_kinds[i] == "pipe")
    ]
    return write_sections(
        folder / f"{name}.inp",
        {
            "JUNCTIONS": "\n".join(junctions),
            "RESERVOIRS": "\n".join(sources),
            **{part: sections[part] for part in ("PIPES", "PUMPS", "VALVES", "CURVES", "COORDINATES")},
            "STATUS": "\n".join(states),
            # The default pattern, 1, applies to every demand.
            "PATTERNS": "\n".join(f"{pattern} 1" for pattern in {row[0] for row in list_rows(sections["PATTERNS"])}),
            "OPTIONS": "Units GPM\nHeadloss H-W\nAccuracy 1e-6\nTolerance 1e-6\nQuality None",
            "TIMES": "Duration 0",
            "END": "",
        },
    )


def simulate_quality(path, quality, hours, step, tolerance=1e-06):
    """EPANET's quality at each node after so many hours of constant flow: a share in %, or an age in h."""
    text = path.read_text("latin-1").replace("Quality None", f"Quality {quality}")
    text = text.replace("Tolerance 1e-6", f"Tolerance {tolerance}")
    times = f"Duration {hours}\nHydraulic Timestep {hours}\nQuality Timestep {step / 3600:.9f}"
    file = path.with_name("quality.inp")
    file.write_text(text.replace("Duration 0", times), "latin-1")
    names, _, values = follow_quality(file, only_last=True)
    return dict(zip(names, values[-1], strict=True))


def follow_quality(path, only_last=False, prepare=lambda _: None):
    """Names of the nodes, the times of EPANET's quality steps, s, and its quality at these times, (times, nodes).

    ``prepare`` changes the model by the function that it receives, which calls EPANET.
    """
    import epanet

    project = epanet.EN_createproject()[1]

    def call(name, *arguments):
        code, *found = getattr(epanet, f"EN_{name}")(project, *arguments)
        assert code < 100, f"{name}: error {code}"
        return found[0] if found else None

    call("open", str(path), os.devnull, "")
    prepare(call)
    call("solveH")
    call("openQ")
    call("initQ", 0)
    nodes = call("getcount", 0)
    times, values, left = [], [], 1
    while left > 0:
        time = call("runQ")
        if not only_last:
            times.append(time)
            values.append(np.array(call("getnodevalues", _QUALITY)))
        left = call("nextQ" if only_last else "stepQ")
    if only_last:  # the next event is the end
        times, values = [time], [np.array(call("getnodevalues", _QUALITY))]
    names = [call("getnodeid", node) for node in range(1, nodes + 1)]
    call("close")
    epanet.EN_deleteproject(project)
    return names, np.array(times, float), np.array(values)


@pytest.fixture(scope="session")
def epanet():
    """The functions of this file."""
    names = (read_library, read_sections, list_rows, write_sections, freeze, simulate_quality, follow_quality)
    return SimpleNamespace(**{function.__name__: function for function in names}, find_library_file=find_library_file)


@pytest.fixture(scope="session")
def fork_file(tmp_path_factory):
    """The EPANET file of a main that divides."""
    path = tmp_path_factory.mktemp("fork") / "fork.inp"
    path.write_text(FORK)
    return path


@pytest.fixture
def call(call):
    """Call ``driftform network`` in an empty directory, with a cache that the tests share."""
    return lambda *arguments: call("network", *arguments)


@pytest.fixture(scope="session", autouse=True)
def _cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
            patch.setenv(name, str(shared_folder(tmp_path_factory, "networks")))
        yield
