"""Finite elements for thin shells of revolution, written for these tests alone: a referee of the closed formulas.

Conical elements with two nodes, Kirchhoff and Love, harmonics cos(n theta) (O. C. Zienkiewicz, The Finite Element Method,
chapter on axisymmetric shells; D. Bushnell, Computerized Buckling Analysis of Shells, for the pressure that turns with the
wall). The pressure is 1 Pa from outside; displacements are axial, radial, around, and the slope along the wall.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import eigsh, spsolve

_GAUSS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, eq=False)
class Shell:
    """A middle surface, (n, 2) of x and r from one point of the axis to the other, and the thickness of each edge, m."""

    nodes: np.ndarray
    wall: np.ndarray
    modulus: float
    poisson: float

    def _elements(self):
        for e, ((x0, r0), (x1, r1)) in enumerate(zip(self.nodes[:-1], self.nodes[1:], strict=True)):
            size = np.hypot(x1 - x0, r1 - r0)
            cos, sin = (x1 - x0) / size, (r1 - r0) / size
            turn = np.array([[cos, sin, 0, 0], [0, 0, 1, 0], [-sin, cos, 0, 0], [0, 0, 0, 1]])
            yield e, size, cos, sin, np.kron(np.eye(2), turn), (r0, r1)

    def _fields(self, a, size):
        """Values and derivatives along the wall of u, v and w at a in 0 to 1, as rows over the eight local freedoms."""
        u, v, w = np.zeros((3, 8)), np.zeros((3, 8)), np.zeros((3, 8))
        u[0, [0, 4]], u[1, [0, 4]] = (1 - a, a), (-1 / size, 1 / size)
        v[0, [1, 5]], v[1, [1, 5]] = (1 - a, a), (-1 / size, 1 / size)
        h = np.array([1 - 3 * a**2 + 2 * a**3, size * (a - 2 * a**2 + a**3), 3 * a**2 - 2 * a**3, size * (a**3 - a**2)])
        d = np.array([-6 * a + 6 * a**2, size * (1 - 4 * a + 3 * a**2), 6 * a - 6 * a**2, size * (3 * a**2 - 2 * a)])
        c = np.array([-6 + 12 * a, size * (-4 + 6 * a), 6 - 12 * a, size * (6 * a - 2)])
        w[0, [2, 3, 6, 7]], w[1, [2, 3, 6, 7]], w[2, [2, 3, 6, 7]] = h, d / size, c / size**2
        return u, v, w

    def _strains(self, n, r, cos, sin, u, v, w):
        return np.array(
            [
                u[1],
                (n * v[0] + u[0] * sin + w[0] * cos) / r,
                -n * u[0] / r + v[1] - v[0] * sin / r,
                -w[2],
                n**2 * w[0] / r**2 - w[1] * sin / r + n * v[0] * cos / r**2,
                2 * (n * w[1] / r - n * w[0] * sin / r**2 + v[1] * cos / r - v[0] * sin * cos / r**2),
            ]
        )

    def _law(self, t):
        plane = np.array([[1, self.poisson, 0], [self.poisson, 1, 0], [0, 0, (1 - self.poisson) / 2]])
        stretch = self.modulus * t / (1 - self.poisson**2) * plane
        return np.block([[stretch, np.zeros((3, 3))], [np.zeros((3, 3)), stretch * t**2 / 12]])

    def _free(self, n):
        """Freedoms that are left: a point of the axis stays there, and one of them is held along it."""
        size = 4 * len(self.nodes)
        held = {1, 2, 3, size - 3, size - 2, size - 1, 0} | ({size - 4} if n else set())
        if n == 0:
            held |= set(range(2, size, 4))
        return np.array([k for k in range(size) if k not in held])

    def _assemble(self, n, forces=None):
        size = 4 * len(self.nodes)
        stiff, load, second = np.zeros((size, size)), np.zeros(size), np.zeros((size, size))
        for e, length, cos, sin, turn, (r0, r1) in self._elements():
            at = slice(4 * e, 4 * e + 8)
            for a, weight in zip((_GAUSS[0] + 1) / 2, _GAUSS[1] / 2, strict=True):
                r = r0 + a * (r1 - r0)
                u, v, w = self._fields(a, length)
                area = weight * length * r
                strain = self._strains(n, r, cos, sin, u, v, w)
                stiff[at, at] += area * turn.T @ strain.T @ self._law(self.wall[e]) @ strain @ turn
                load[at] -= area * w[0] @ turn
                if forces is not None:
                    along, around = -w[1], (v[0] * cos + n * w[0]) / r
                    pressed = np.outer(w[0], strain[0] + strain[1]) + np.outer(u[0], along) + np.outer(v[0], around)
                    form = forces[e, 0] * np.outer(along, along) + forces[e, 1] * np.outer(around, around)
                    second[at, at] += area * turn.T @ (form + (pressed + pressed.T) / 2) @ turn
        return stiff, load, second

    def press(self):
        """Return forces N and moments M along and around (e, 4), N/m and N, and the volume that is lost, m3, under 1 Pa."""
        stiff, load, _ = self._assemble(0)
        free = self._free(0)
        moved = np.zeros(len(load))
        moved[free] = spsolve(csc_array(stiff[np.ix_(free, free)]), load[free])
        found = []
        for e, length, cos, sin, turn, (r0, r1) in self._elements():
            u, v, w = self._fields(0.5, length)
            strain = self._strains(0, (r0 + r1) / 2, cos, sin, u, v, w) @ turn @ moved[4 * e : 4 * e + 8]
            found.append((self._law(self.wall[e]) @ strain)[[0, 1, 3, 4]])
        return np.array(found), 2 * np.pi * float(load @ moved)

    def stress(self):
        """Return the greatest stress at the faces of each edge, under 1 Pa."""
        forces, _ = self.press()
        t = self.wall[:, None]
        faces = [forces[:, :2] / t + s * 6 * forces[:, 2:] / t**2 for s in (-1, 1)]
        return np.abs(np.concatenate(faces, axis=1)).max(axis=1)

    def buckling(self, lobes=range(2, 9)):
        """Return the lowest pressure (Pa) at which the perfect shell buckles, its lobes, and the mode's radial part."""
        forces, _ = self.press()
        best = (np.inf, 0, None)
        for n in lobes:
            stiff, _, second = self._assemble(n, forces)
            free = self._free(n)
            inner = np.ix_(free, free)
            value, mode = eigsh(csc_array(-second[inner]), k=1, M=csc_array(stiff[inner]), which="LA")
            if value[0] > 0 and 1 / value[0] < best[0]:
                whole = np.zeros(len(stiff))
                whole[free] = mode[:, 0]
                best = (1 / value[0], n, whole[1::4])
        return best


def refine(contour, step):
    """Return a contour with points at most ``step`` apart, and for each edge the one that it is a piece of."""
    points, owners = [contour[0]], []
    for k, (a, b) in enumerate(itertools.pairwise(contour)):
        count = max(1, int(np.ceil(np.hypot(*(b - a)) / step)))
        points += [a + (b - a) * i / count for i in range(1, count + 1)]
        owners += [k] * count
    return np.array(points), np.array(owners)
