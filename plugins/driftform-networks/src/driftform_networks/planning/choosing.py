"""Chooses the bodies that together see most, and bounds what any choice could see."""

from collections.abc import Sequence

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_networks.hydraulics.network import BoolArray, IntArray, Snapshot


def choose_fleet(seen: FloatArray, length: FloatArray, size: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Choose bodies one after the other, each the one that adds most, then exchange them while that helps; any may be chosen more than once.

    Bodies travel independently, so that a fleet sees a link with 1 - prod(1 - p). The expected length that it sees is a
    monotone submodular function of the fleet: the greedy choice sees at least 1 - 1/e of what the best choice of this
    size sees (Nemhauser, Wolsey and Fisher 1978, doi:10.1007/BF01588971). The bound that is returned is usually closer:
    k more bodies add at most k times what the best of them adds now (Leskovec et al. 2007, doi:10.1145/1281192.1281239).
    The first body is the one that sees most alone, which may be a poor partner for the others; hence the exchanges.

    Args:
        seen: probability that each body sees each link, (bodies, links).
        length: of each link, m, (links,).
        size: number of bodies to choose.

    Returns:
        chosen, coverage, bound: row of each body that is chosen, in order; the share of the length that the first 1, 2,
            ... of the greedy choice see, and as the last that all see after the exchanges; and an upper bound on the share
            that any choice of so many rows sees, (size,) each.
    """
    missed, total = np.ones(len(length)), length.sum()
    chosen, coverage = np.empty(size, np.int64), np.empty(size)
    bound, numbers = np.full(size, np.inf), np.arange(1, size + 1)
    for step in range(size):
        gain = seen @ (length * missed)
        covered = total - length @ missed
        np.minimum(bound, covered + numbers * gain.max(), out=bound)
        # Rounding must not decide between equals: the first of them is chosen on every machine.
        chosen[step] = np.flatnonzero(gain >= gain.max() * (1 - 1e-9))[0]
        missed = missed * (1 - seen[chosen[step]])
        coverage[step] = (total - length @ missed) / total
    bound, improved = np.maximum(np.minimum(bound / total, 1.0), coverage), True
    while improved:
        improved = False
        for place in range(size):
            others = np.prod(1 - np.delete(seen[chosen], place, axis=0), axis=0)
            sees = (total - (1 - seen) @ (length * others)) / total
            best = int(np.flatnonzero(sees >= sees.max() * (1 - 1e-9))[0])
            if sees[best] > sees[chosen[place]] * (1 + 1e-9):
                chosen[place], improved = best, True
                coverage[-1] = sees[best]
    return chosen, coverage, bound


def bound_steering(
    flows: Sequence[Sequence[Snapshot]],
    releases: Sequence[int],
    reachable: BoolArray,
    size: int,
    blocked: Sequence[int] = (),
) -> float:
    """Return an upper bound on the share of the reachable length that bodies see that choose their route at every node.

    A linear program: bodies are a flow of ``size`` from the releases along the water, which may end anywhere. Of those that
    pass a link in all hours, one sees it, and the others pass unseeing. Whole bodies, and chance, see less. Tanks and
    reservoirs end a route, and none leads through ``blocked`` links. Each body travels by one of the ``flows``; one of several
    snapshots, which follow each other, allows every direction that any of them has.

    Raises WorkFailedError if the solver finds no solution.
    """
    network = flows[0][0].network
    # Link, tail and head of each direction in which water flows at some time, (arcs, 3) for each flow.
    snaps = [[np.column_stack([snap.links, snap.tail, snap.head]) for snap in flow] for flow in flows]
    arcs: list[IntArray] = [s[0] if len(s) == 1 else np.unique(np.concatenate(s), axis=0) for s in snaps]
    worth, nodes = np.where(reachable, network.worth, 0.0), len(network.nodes)
    balance = []
    for link, tail, head in (rows.T for rows in arcs):
        ones, column, shape = np.ones(len(link)), np.arange(len(link)), (nodes, len(link))
        passes = ~network.stores[head] & ~np.isin(link, blocked)
        balance.append(
            sparse.csr_array((ones, (tail, column)), shape) - sparse.csr_array((ones * passes, (head, column)), shape)
        )
    source = sparse.csr_array((-np.ones(len(releases)), (releases, np.arange(len(releases)))), (nodes, len(releases)))
    # Columns: bodies that see in each link of each flow, those that pass unseeing, and those from each release of each flow.
    along = sparse.block_diag(balance)
    conserved = sparse.hstack([along, along, sparse.block_diag([source] * len(flows))])
    links = np.concatenate([rows[:, 0] for rows in arcs])
    moves, starts = len(links), len(flows) * len(releases)
    # A link that is passed in one direction at one time has no row of its own: a bound is enough, and far faster.
    again = np.flatnonzero(np.bincount(links) > 1)
    seen = sparse.csr_array((np.ones(moves), (links, np.arange(moves))))[again]
    found = linprog(
        np.concatenate([-worth[links] / worth.sum(), np.zeros(moves + starts)]),
        A_ub=sparse.vstack([conserved, sparse.hstack([seen, sparse.csr_array((len(again), moves + starts))])]).tocsr(),
        b_ub=np.concatenate([np.zeros(conserved.shape[0]), np.ones(len(again))]),
        A_eq=sparse.csr_array(np.concatenate([np.zeros(2 * moves), np.ones(starts)])[None]),
        b_eq=[float(size)],
        bounds=[(0, 1)] * moves + [(0, None)] * (moves + starts),
        method="highs",
    )
    if not found.success:
        raise WorkFailedError(f"the bound of perfect steering cannot be computed: {found.message}")
    return min(1.0, -float(found.fun))
