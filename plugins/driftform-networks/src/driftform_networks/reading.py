"""Opens a network by the path of its EPANET file, or by the name of one that WNTR ships."""

import hashlib
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.util.files import is_file
from driftform_networks.cache import Arrays, find_cache, hash_content, load_arrays, save_arrays
from driftform_networks.network import Hydraulics, Network

_FORMAT = 1
"""Increase it whenever a network is computed or stored differently."""


def open_network(source: str | Path, cache: Path | None = None) -> Network:
    """Return a network with its flows; EPANET runs only if the cache does not hold them.

    Parameters
    ----------
    source
        path of an EPANET file (.inp), or the name of a network that WNTR ships, such as ``"Net3"``.
    cache
        directory for results; ``None`` for the user's.

    Raises
    ------
    InputError
        if there is no such file, or EPANET refuses it.
    """
    path = _find_file(str(source))
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    stored = find_cache(cache) / f"{hash_content({'network': digest, 'format': _FORMAT})}.npz"
    if (arrays := load_arrays(stored)) is not None:
        return _unpack(arrays, path.stem, digest)
    from driftform_networks.epanet import run_epanet

    network = run_epanet(path)
    save_arrays(stored, _pack(network))
    return network


def _find_file(text: str) -> Path:
    path = Path(text)
    if is_file(path):
        return path
    # Found without importing WNTR, which takes seconds.
    spec = find_spec("wntr")
    folder = Path(spec.origin).parent / "library" / "networks" if spec and spec.origin else path / "none"
    shipped = {file.stem: file for file in folder.glob("*.inp")}
    if text in shipped:
        return shipped[text]
    raise InputError(
        f"NET '{text}': no such file, and WNTR ships no network of that name{did_you_mean(text, shipped)}"
    )


def _pack(network: Network) -> Arrays:
    hydraulics = network.hydraulics
    return {
        "nodes": np.array(network.nodes),
        "node_kinds": np.array(network.node_kinds),
        "elevation": network.elevation,
        "places": network.places,
        "links": np.array(network.links),
        "link_kinds": np.array(network.link_kinds),
        "start": network.start,
        "end": network.end,
        "length": network.length,
        "diameter": network.diameter,
        "vertices": np.vstack([np.zeros((0, 2)), *network.vertices]),
        "counts": np.array([len(points) for points in network.vertices], np.int64),
        "times": hydraulics.times,
        "duration": np.array(hydraulics.end),
        "flow": hydraulics.flow,
        "outflow": hydraulics.outflow,
        "head": hydraulics.head,
        "warnings": np.array(hydraulics.warnings, dtype=np.str_),
    }


def _unpack(arrays: Arrays, name: str, digest: str) -> Network:
    def words(key: str) -> tuple[str, ...]:
        return tuple(arrays[key].tolist())

    hydraulics = Hydraulics(
        arrays["times"],
        float(arrays["duration"]),
        arrays["flow"],
        arrays["outflow"],
        arrays["head"],
        words("warnings"),
    )
    return Network(
        name,
        digest,
        words("nodes"),
        words("node_kinds"),
        arrays["elevation"],
        arrays["places"],
        words("links"),
        words("link_kinds"),
        arrays["start"],
        arrays["end"],
        arrays["length"],
        arrays["diameter"],
        tuple(np.split(arrays["vertices"], np.cumsum(arrays["counts"])[:-1])),
        hydraulics,
    )
