"""Your own strategy over an optimiser of a library: differential evolution of pymoo, over B-splines."""

import numpy as np
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination

import driftform as df
from driftform.interfaces import GenerationStrategy, SearchSpace, Table
from driftform.types import Candidate


class Differential(GenerationStrategy[Table]):
    name = "differential"

    def __init__(self, options, space):
        super().__init__(options, space)
        problem = Problem(n_var=len(space.grammar.list_genes()), n_obj=1, xl=0.0, xu=1.0)
        self._optimiser = DE(pop_size=20)
        self._optimiser.setup(problem, termination=NoTermination(), seed=int(space.rng.integers(2**31)))

    def begin_generation(self):
        self._asked = self._optimiser.ask()
        return [Candidate(self.space.grammar.make_genome(vector)) for vector in self._asked.get("X")]

    def end_generation(self, first, evaluations):
        self._asked.set("F", np.array([[100 - one.fitness.mean()] for one in evaluations]))
        self._optimiser.tell(infills=self._asked)


pipeline = df.load_study("pipe-inspection", targets=["TP5"], use={"grammar": "bspline"}).make_pipeline()
strategy = Differential(Table(), SearchSpace(pipeline.grammar, ("TP5",), np.random.default_rng(1)))
found = []
while len(found) < 300:
    evaluations = pipeline.evaluate([candidate.genome for candidate in strategy.ask(300 - len(found))])
    strategy.tell(len(found), evaluations)
    found += evaluations
print(f"fitness {max(one.fitness[0] for one in found):.2f} % for TP5")
