"""Your own grammar: a genome is twelve tilts in degrees, of the modules of a tail aft of the core."""

from dataclasses import replace

import numpy as np

import driftform as df
from driftform.interfaces import Grammar
from driftform.types import Module, Morphology


class TailGrammar(Grammar):
    name = "tail"

    def list_genes(self):
        return [(-20.0, 20.0)] * 12

    def express(self, genome):
        return Morphology(aft=tuple(Module(0.01, np.deg2rad(tilt)) for tilt in self.read_symbols(genome)))


study = df.load_study("pipe-inspection", targets=["TP5"], run={"seed": 1})
pipeline = replace(study.make_pipeline(), grammar=TailGrammar(TailGrammar.Options()))
rng = np.random.default_rng(1)
best = max(pipeline.evaluate([pipeline.grammar.random(rng) for _ in range(100)]), key=lambda e: e.fitness[0])
print(f"tilts {pipeline.grammar.to_text(best.genome)}: fitness {best.fitness[0]:.2f} % for TP5")
