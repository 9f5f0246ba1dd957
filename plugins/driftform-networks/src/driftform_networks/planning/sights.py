"""What is seen of pipes of a kind, how much each counts, and what receivers hear of bodies that pass."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from driftform.errors import InputError, did_you_mean
from driftform.types import FloatArray
from driftform.util import files
from driftform_networks.hydraulics.network import BoolArray, IntArray, Network

MAX_GROUPS, BINS = 12, 5
"""Most values that are groups of their own, and the groups of numbers with more."""


def read_pipes(path: Path | None, network: Network) -> dict[str, list[str]]:
    """Return the columns of a CSV file for each link, empty where it has no row, and the column ``diameter`` (m).

    Raises InputError if the first column names no links of the network.
    """
    columns = {"diameter": [f"{bore:g}" if bore else "" for bore in network.diameter]}
    if path is None:
        return columns
    rows = list(csv.reader(io.StringIO(files.read_text(path))))
    header = [name.strip() for name in rows[0]] if rows else []
    if len(header) < 2:
        raise InputError(f"{path}: expected a header, the first column with names of links, such as link,material,risk")
    index = {name: row for row, name in enumerate(network.links)}
    columns |= {name: [""] * len(index) for name in header[1:]}
    for number, row in enumerate(rows[1:], 2):
        if not any(row):
            continue
        if row[0].strip() not in index:
            raise InputError(f"{path}: line {number}: {network.name} has no link {row[0].strip()!r}")
        for name, value in zip(header[1:], row[1:], strict=False):
            columns[name][index[row[0].strip()]] = value.strip()
    return columns


def pick_column(columns: Mapping[str, Sequence[str]], option: str, name: str) -> Sequence[str]:
    """Return a column that an option names. Raises InputError if there is no such column."""
    if name not in columns:
        raise InputError(f"{option} {name}: no such column{did_you_mean(name, columns)}")
    return columns[name]


def read_weights(columns: Mapping[str, Sequence[str]], name: str) -> FloatArray:
    """Return how much each link counts, (links,): the numbers of a column, 0 where it is empty.

    Raises InputError if there is no such column, or a value is not a number of at least 0.
    """
    values = [_to_number(value or "0") for value in pick_column(columns, "--weight", name)]
    for value, text in zip(values, columns[name], strict=True):
        if not 0 <= value < np.inf:
            raise InputError(f"--weight {name}: weight '{text}': expected a number of at least 0")
    if not any(values):
        raise InputError(f"--weight {name}: all weights are 0")
    return np.array(values)


def _to_number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan


def group_sight(
    network: Network, seen: FloatArray, reachable: BoolArray, values: Sequence[str]
) -> list[tuple[str, float, float]]:
    """Return value, length (m) and share of it that is seen, for each value of a column in the length that is in reach.

    Numbers with more than :data:`MAX_GROUPS` values are groups of about equal length.
    """
    rows = np.flatnonzero(reachable & (network.length > 0))
    numbers = np.array([_to_number(values[row]) for row in rows.tolist()])
    names = [values[row] or "-" for row in rows.tolist()]
    if len(set(names)) > MAX_GROUPS and np.isfinite(numbers).all():
        order = np.argsort(numbers, kind="stable")
        done = np.cumsum(network.length[rows][order])
        edges = numbers[order][np.searchsorted(done, done[-1] * np.arange(1, BINS) / BINS)]
        # Equal numbers are in one group.
        part = np.searchsorted(edges, numbers)
        ends = {group: numbers[part == group] for group in set(part.tolist())}
        names = [f"{ends[group].min():g} to {ends[group].max():g}" for group in part.tolist()]
        rank = {name: float(group) for name, group in zip(names, part.tolist(), strict=True)}
    else:
        rank = {name: _to_number(name) for name in names}
    found: dict[str, list[float]] = {}
    for row, name in zip(rows.tolist(), names, strict=True):
        total = found.setdefault(name, [0.0, 0.0])
        total[0] += network.length[row]
        total[1] += network.length[row] * seen[row]
    ordered = sorted(found, key=lambda name: (np.nan_to_num(rank[name], nan=np.inf), name))
    return [(name, found[name][0], found[name][1] / found[name][0]) for name in ordered]


def find_heard(network: Network, receivers: Sequence[int] | IntArray, reach: float) -> FloatArray:
    """Return the share of each link within a distance of a receiver, along the pipes, (links,).

    Args:
        receivers: nodes with a receiver.
        reach: acoustic range, m.
    """
    nodes = len(network.nodes)
    pipes = network.is_pipe
    start, end, length = network.start[pipes], network.end[pipes], network.length[pipes]
    # Of pipes side by side the shortest counts.
    order = np.argsort(-length, kind="stable")
    graph = sparse.lil_array((nodes, nodes))
    graph[start[order], end[order]] = length[order]
    away = dijkstra(graph.tocsr(), directed=False, indices=list(receivers), min_only=True, limit=reach)
    left = np.maximum(reach - np.column_stack([away[network.start], away[network.end]]), 0.0)
    left[~np.isfinite(left)] = 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(pipes, np.minimum(left.sum(axis=1) / network.length, 1.0), 0.0)
