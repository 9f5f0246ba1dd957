"""Panels satisfy the contract of a model of hydrodynamics, to the accuracy of their arithmetic."""

from driftform.testing import HydrodynamicsContract
from driftform_panels.solve import PanelMethod, PanelOptions


class TestPanels(HydrodynamicsContract):
    def plugin(self):
        return PanelMethod(PanelOptions())


class TestFewPanels(HydrodynamicsContract):
    def plugin(self):
        return PanelMethod(PanelOptions(panels=4, corner=1.0))
