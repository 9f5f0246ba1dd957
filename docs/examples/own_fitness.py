"""Your own fitness in your own search: agents that see as many heights of the pipe as they can.

As a plugin the same class serves every command: docs/write-a-plugin.md.
"""

from dataclasses import replace

import numpy as np

import driftform as df
from driftform.interfaces import Fitness, Table


class Sweep(Fitness[Table]):
    """Range of heights of a flight before its first touch of the wall, in percent of the bore."""

    name = "sweep"

    def score(self, trajectory, scenario, agent):
        touch = np.inf if trajectory.contact is None else trajectory.contact
        heights = trajectory.position[trajectory.t <= touch, 2]
        bore = 2 * scenario.pipe.segments[0].radius
        return np.full(len(scenario.targets), 100 * np.ptp(heights) / bore)


study = df.load_study("pipe-inspection", ["release.position=[0,0,-0.6]"], run={"seed": 1})
pipeline = replace(study.make_pipeline(), fitness=Sweep(Table()))
rng = np.random.default_rng(3)
genomes = [pipeline.grammar.random(rng) for _ in range(40)]
for generation in range(4):
    best = max(pipeline.evaluate(genomes), key=lambda evaluation: evaluation.fitness[0])
    print(f"generation {generation}: sees {best.fitness[0]:.1f} % of the heights")
    genomes = [best.genome, *(pipeline.grammar.mutate(best.genome, rng, 0.05) for _ in range(39))]
