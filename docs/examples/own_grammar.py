"""Your own grammar: a genome is twelve tilts in degrees, of the modules of a tail aft of the core."""

from dataclasses import replace

import numpy as np

import driftform as df
from driftform.interfaces import Grammar
from driftform.types import Genome, Module, Morphology


class TailGrammar(Grammar):
    name = "tail"

    def random(self, rng):
        return self.parse(" ".join(map(str, rng.integers(-20, 21, 12))))

    def flip(self, genome, index, rng):
        symbols = dict(enumerate(genome.symbols)) | {index: str(rng.integers(-20, 21))}
        return Genome(self.name, tuple(symbols.values()))

    def crossover(self, a, b, rng):
        x, y, cut = a.symbols, b.symbols, rng.integers(1, 12)
        return Genome(self.name, x[:cut] + y[cut:]), Genome(self.name, y[:cut] + x[cut:])

    def express(self, genome):
        return Morphology(aft=tuple(Module(0.01, np.deg2rad(float(tilt))) for tilt in genome.symbols))

    def to_text(self, genome):
        return " ".join(genome.symbols)

    def parse(self, text):
        return Genome(self.name, tuple(text.split()))


study = df.load_study("pipe-inspection", targets=["TP5"], run={"seed": 1})
pipeline = replace(study.make_pipeline(), grammar=TailGrammar(TailGrammar.Options()))
rng = np.random.default_rng(1)
best = max(pipeline.evaluate([pipeline.grammar.random(rng) for _ in range(100)]), key=lambda e: e.fitness[0])
print(f"tilts {pipeline.grammar.to_text(best.genome)}: fitness {best.fitness[0]:.2f} % for TP5")
