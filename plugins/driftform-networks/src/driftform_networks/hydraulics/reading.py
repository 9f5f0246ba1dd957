"""Opens a network by the path of its EPANET file, or by the name of one that this package ships."""

import hashlib
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.util import files
from driftform_networks.cache import find_cache, hash_content, load_arrays, save_arrays
from driftform_networks.hydraulics.epanet import Changes, run_epanet
from driftform_networks.hydraulics.network import Hydraulics, Network

_FORMAT = 3
"""Increase it whenever a network is computed or stored differently."""

_HYDRAULICS = "hydraulics."


def open_network(source: str | Path, cache: Path | None = None, changes: Changes | None = None) -> Network:
    """Return a network with its flows; EPANET runs only if the cache does not hold them.

    Args:
        source: path of an EPANET file (.inp), or ``"Net3"``, an example of EPANET.
        cache: directory for results; ``None`` for the user's.
        changes: to the model of the file.

    Raises InputError if there is no such file, or EPANET refuses it.
    """
    path = _find_file(str(source))
    content = [hashlib.sha256(path.read_bytes()).hexdigest(), _FORMAT, asdict(changes or Changes())]
    digest = hash_content({"network": content})
    stored = find_cache(cache) / f"{digest}.npz"
    if (arrays := load_arrays(stored)) is None:
        arrays = run_epanet(path, changes)
        save_arrays(stored, arrays)
    values: dict[str, Any] = {
        key: tuple(array.tolist()) if array.dtype.kind == "U" else array if array.ndim else array.item()
        for key, array in arrays.items()
    }
    corners = np.split(values.pop("vertices"), np.cumsum(values.pop("counts"))[:-1])
    flows = {key: values.pop(f"{_HYDRAULICS}{key}") for key in Hydraulics.__dataclass_fields__}
    return Network(path.stem, digest, vertices=tuple(corners), hydraulics=Hydraulics(**flows), **values)


def _find_file(text: str) -> Path:
    path = Path(text)
    if files.is_file(path):
        return path
    shipped = {file.stem: file for file in Path(__file__).with_name("examples").glob("*.inp")}
    if text in shipped:
        return shipped[text]
    raise InputError(
        f"NET '{text}': no such file, and no network of that name comes with driftform{did_you_mean(text, shipped)}"
    )
