"""Whether the map of a network is drawn to scale: then the angles of its pipes are those of the map."""

import numpy as np

from driftform_networks.network import Network

TOLERANCE = 0.1
"""Largest deviation of drawn from given length at which a link counts as drawn to scale."""

MOST_OFF = 0.2
"""Largest share of the total length that is not to scale."""


def is_to_scale(network: Network) -> float | None:
    """Return the metres for each unit of the map if it is drawn to scale, else ``None``.

    The scale is the median, by length, of given over drawn lengths; the map is to scale if at least 80 % of the length
    deviates from it by at most 10 %.
    """
    drawn = np.array([
        np.linalg.norm(np.diff(network.polyline(link), axis=0), axis=1).sum() for link in range(len(network.links))
    ])  # fmt: skip
    pipes = (drawn > 0) & (network.length > 0)
    if not pipes.any():
        return None
    ratio, length = network.length[pipes] / drawn[pipes], network.length[pipes]
    order = np.argsort(ratio)
    middle = np.searchsorted(np.cumsum(length[order]), length.sum() / 2)
    scale = float(ratio[order][min(middle, len(order) - 1)])
    off = length[np.abs(ratio / scale - 1) > TOLERANCE].sum() / length.sum()
    return scale if off <= MOST_OFF else None
