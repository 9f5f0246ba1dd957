"""Opens a network by the path of its EPANET file, or by the name of one that WNTR ships."""

import hashlib
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from driftform.errors import InputError, did_you_mean
from driftform.util import files
from driftform_networks.cache import Arrays, find_cache, hash_content, load_arrays, save_arrays
from driftform_networks.network import Hydraulics, Network

_FORMAT = 2
"""Increase it whenever a network is computed or stored differently."""

_HYDRAULICS = "hydraulics."


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
        return _unpack(arrays, path.stem)
    from driftform_networks.epanet import run_epanet

    network = run_epanet(path)
    save_arrays(stored, _pack(network))
    return network


def _find_file(text: str) -> Path:
    path = Path(text)
    if files.is_file(path):
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
    """Return the values of a network as arrays; those of its hydraulics have a prefix."""
    own = {
        name: value
        for name, value in vars(network).items()
        if name not in ("hydraulics", "vertices", "scale")
    }
    flows = {f"{_HYDRAULICS}{name}": value for name, value in vars(network.hydraulics).items()}
    return {
        **{
            name: np.array(value, np.str_ if isinstance(value, tuple) else None)
            for name, value in (own | flows).items()
        },
        "vertices": np.vstack([np.zeros((0, 2)), *network.vertices]),
        "counts": np.array([len(points) for points in network.vertices], np.int64),
    }


def _unpack(arrays: Arrays, name: str) -> Network:
    values: dict[str, Any] = {key: _restore(array) for key, array in arrays.items()}
    vertices = np.split(values.pop("vertices"), np.cumsum(values.pop("counts"))[:-1])
    hydraulics = {key: values.pop(key) for key in arrays if key.startswith(_HYDRAULICS)}
    flows = Hydraulics(**{key.removeprefix(_HYDRAULICS): value for key, value in hydraulics.items()})
    return Network(**values | {"name": name, "vertices": tuple(vertices), "hydraulics": flows})


def _restore(array: npt.NDArray[Any]) -> Any:
    if not array.ndim:
        return array.item()
    return tuple(array.tolist()) if array.dtype.kind == "U" else array
