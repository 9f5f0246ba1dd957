import pytest

from driftform.testing import GrammarContract
from driftform_lsystem.grammar import LSystemGrammar
from driftform_lsystem.growth import LSystemOptions


class TestLSystem(GrammarContract):
    nonsense = (*GrammarContract.nonsense, "addF-tiltp-0-S", "addF-tiltp-3-S-moveF", "C: addF | S:", "-", "|")

    def plugin(self):
        return LSystemGrammar(LSystemOptions())


class TestLSystemReadOtherwise(GrammarContract):
    @pytest.fixture(autouse=True, params=["last and skip", "neighbour", "one iteration"])
    def reading(self, request):
        self.options = {
            "last and skip": LSystemOptions(repetition="last", occupied="skip"),
            "neighbour": LSystemOptions(tilt_reference="neighbour", tilt_2_deg=45.0),
            "one iteration": LSystemOptions(iterations=1),
        }[request.param]

    def plugin(self):
        return LSystemGrammar(self.options)
