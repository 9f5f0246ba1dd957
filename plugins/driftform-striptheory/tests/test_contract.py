from driftform.testing import HydrodynamicsContract
from driftform_striptheory.coefficients import StripTheory, StripTheoryOptions


class TestStripTheory(HydrodynamicsContract):
    tolerance = 1e-12

    def plugin(self):
        return StripTheory(StripTheoryOptions())


class TestStripTheoryWithTheTrueVolume(HydrodynamicsContract):
    tolerance = 1e-12

    def plugin(self):
        return StripTheory(StripTheoryOptions(m11="volume"))
