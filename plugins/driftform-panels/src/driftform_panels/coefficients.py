"""Added mass of the outer contour by panels, without damping."""

import numpy as np

from driftform.interfaces import Hydrodynamics
from driftform.scenario import Fluid
from driftform.types import Body, Coefficients
from driftform_panels.solve import PanelOptions, solve


class PanelMethod(Hydrodynamics[PanelOptions]):
    """Added mass of any body of revolution in unbounded potential flow, by boundary elements on the meridian."""

    name = "panels"
    Options = PanelOptions

    def coefficients(self, body: Body, fluid: Fluid) -> Coefficients:
        """Return the added mass about the centre of buoyancy; damping is zero."""
        solution = solve(body.outer, self.options)
        return Coefficients(fluid.density * solution.matrix(), origin=np.array([solution.origin, 0.0, 0.0]))
