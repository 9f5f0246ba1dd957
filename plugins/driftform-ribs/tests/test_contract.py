"""The strategy with an archive of pyribs keeps every promise of a strategy, with both archives."""

from driftform.testing import StrategyContract
from driftform_bspline.grammar import BSplineGrammar, BSplineOptions
from driftform_ribs.strategy import RibsOptions, RibsStrategy


class TestRibs(StrategyContract):
    def plugin(self, space):
        return RibsStrategy(RibsOptions(cells=50, batch=10, random=20), space)


class TestRibsWithAGrid(StrategyContract):
    def plugin(self, space):
        return RibsStrategy(RibsOptions(archive="grid", cells=64, batch=7, random=15), space)


class TestRibsOverASingleStation(StrategyContract):
    def plugin(self, space):
        options = RibsOptions(archive="grid", cells=20, stations=(1.0,), objective="mean", batch=7, random=15)
        return RibsStrategy(options, space)


class TestCMAME(StrategyContract):
    emitter = "cma-me"

    def grammar(self):
        return BSplineGrammar(BSplineOptions())

    def plugin(self, space):
        return RibsStrategy(RibsOptions(archive="grid", cells=64, emitter=self.emitter, emitters=2, batch=14), space)


class TestCMAMAE(TestCMAME):
    emitter = "cma-mae"
