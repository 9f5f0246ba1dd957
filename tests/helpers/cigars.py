"""Bodies with ballast, for searches of tuned bodies; here, because another process must be able to import them."""

import numpy as np

from driftform.interfaces import PhenotypeBuilder, Table
from driftform.types import Body, Core, Moments

RADIUS = 0.02
"""Of the bodies, m."""


class Cigars(PhenotypeBuilder[Table]):
    """Solid cigars that float, with ballast at the origin; the first module decides how long they are."""

    name = "cigars"
    most = 0.5

    def build(self, morphology):
        aft, fore = (
            0.03 + sum(m.length + 0.001 * (index + 1) * m.tilt for index, m in enumerate(side))
            for side in (morphology.aft, morphology.fore)
        )
        outer = np.array([(-aft, 0.0), (-aft / 2, RADIUS), (fore / 2, RADIUS), (fore, 0.0)])
        volume = morphology.tuning / 11_000
        return Body(
            outer,
            np.zeros((0, 2)),
            np.array([-aft, fore]),
            Core(0.01, 0.0),
            0.001,
            500.0,
            ballast=Moments(volume),
            ballast_density=11_000.0,
        )

    def find_tunings(self, morphology):
        return (0.0, self.most)


class Corks(Cigars):
    """Bodies that float whatever their ballast."""

    most = 1e-6
