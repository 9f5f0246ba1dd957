"""Where bodies that settle or rise slowly are in the section of a pipe: the balance of Rouse, by finite volumes."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from driftform.water.gusts import eddy_diffusivity


def mean_height(speed, friction, radius, room, n=40):
    """Return the mean height (m) above the axis of what sinks at ``speed`` (m/s) within ``room`` (m) of the axis of a pipe.

    Nothing passes the edge of the room, and everywhere else the flux w c - K grad c has no divergence: Rouse's equation (1937)
    in the section of a pipe of ``radius`` (m), with the eddy diffusivity K of its ``friction`` velocity (m/s).
    """
    edges, turn = np.linspace(0.0, room, n + 1), 2 * np.pi / (2 * n)
    middles, angles = 0.5 * (edges[1:] + edges[:-1]), (np.arange(2 * n) + 0.5) * turn
    rows, columns, values = [], [], []

    def exchange(a, b, spread, carried):
        """Add the flux from cell ``a`` to cell ``b``: spread (c_a - c_b) + carried (c_a + c_b) / 2."""
        for cell, sign in ((a, -1.0), (b, 1.0)):
            rows.extend((cell, cell))
            columns.extend((a, b))
            values.extend((sign * (spread + carried / 2), sign * (carried / 2 - spread)))

    def cell(i, j):
        return i * 2 * n + j % (2 * n)

    for i in range(n):
        diffusivity = friction * eddy_diffusivity(radius - middles[i], radius)
        step = edges[1] - edges[0]
        for j in range(2 * n):
            # Across an angle, and outward; sinking is -speed along the vertical, which is at the angle pi / 2.
            along = -speed * np.cos(angles[j] + turn / 2)
            exchange(cell(i, j), cell(i, j + 1), diffusivity * step / (middles[i] * turn), along * step)
            if i < n - 1:
                between = friction * eddy_diffusivity(radius - edges[i + 1], radius)
                face = edges[i + 1] * turn
                exchange(cell(i, j), cell(i + 1, j), between * face / step, -speed * np.sin(angles[j]) * face)
    matrix = coo_array((values, (rows, columns)), shape=(2 * n * n, 2 * n * n)).tolil()
    areas = np.repeat(middles * (edges[1] - edges[0]) * turn, 2 * n)
    # One equation follows from the others: the whole amount takes its place.
    matrix[0] = areas
    right = np.zeros(2 * n * n)
    right[0] = 1.0
    density = spsolve(matrix.tocsr(), right)
    heights = np.outer(middles, np.sin(angles)).ravel()
    return float((density * areas * heights).sum())
