"""Optimisers of pymoo over genomes that are vectors, for one objective or several."""

from collections.abc import Mapping, Sequence
from functools import reduce
from importlib import import_module
from typing import Any, Literal

import numpy as np
from pydantic import model_validator

from driftform.interfaces import GenerationStrategy, Result, SearchSpace, Table, option
from driftform.types import Candidate, Evaluation, FloatArray

MANY = ("nsga2", "nsga3")
"""Algorithms for more than one objective."""

FORBIDDEN = 1e6
"""Every objective of what is not feasible; its violation is added."""


class PymooOptions(Table):
    """The algorithm and its objectives."""

    algorithm: Literal["nsga2", "nsga3", "ga", "de", "cmaes"] = option(
        "nsga2",
        "'nsga2' (Deb et al. 2002) or 'nsga3' (Deb and Jain 2014) for objectives that compete; 'ga', 'de' (Storn and Price "
        "1997) or 'cmaes' (Hansen 2016) for one",
    )
    objectives: tuple[str, ...] = option(
        ("fitness",),
        "what to improve: 'fitness', the mean over targets, or that for a target by its name; or a measure, such as print_mass, to "
        "make it less, and -print_mass to make it more; -fitness_90 for the fitness that 90 % of robustness.survey flights reach",
        min_length=1,
        max_length=10,
    )
    population: int = option(50, "members of a generation", "", ge=4, le=100_000)

    @model_validator(mode="after")
    def _check_objectives(self) -> "PymooOptions":
        if len(self.objectives) > 1 and self.algorithm not in MANY:
            raise ValueError(
                f"'objectives' has {len(self.objectives)}, and '{self.algorithm}' takes one: set algorithm to 'nsga2', or leave one"
            )
        return self


class PymooStrategy(GenerationStrategy[PymooOptions]):
    """An optimiser of pymoo searches genomes that are vectors, such as those of bspline, for one objective or a front of several.

    A body that cannot be built, released or flown, or misses a constraint, is worse than any other: among these a smaller
    sum of violations is better. An optimiser that has converged begins anew.
    """

    name = "pymoo"
    Options = PymooOptions

    def __init__(self, options: PymooOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._optimiser = self._make_optimiser()
        self._names = [name.removeprefix("-") for name in options.objectives]
        more = ("fitness", *space.targets)
        self._signs = np.array([-1.0 if name.startswith("-") or name in more else 1.0 for name in options.objectives])
        # The evaluations that no other dominates, and their objectives.
        self._front, self._values = np.empty(0), np.empty((0, len(self._names)))

    def begin_generation(self) -> list[Candidate]:
        """Return the next generation of the optimiser, or the first one of a new optimiser."""
        self._population: Any = self._optimiser.ask() if self._optimiser.has_next() else ()
        if self._population is None or not len(self._population):
            self._optimiser = self._make_optimiser()
            self._population = self._optimiser.ask()
        make_genome = self.space.grammar.make_genome
        threshold = (-np.inf,) * len(self.space.targets) if "fitness_90" in self._names else None
        vectors = self._population.get("X")
        return [Candidate(make_genome(vector), (), self.generation, threshold=threshold) for vector in vectors]

    def end_generation(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Tell the optimiser the objectives, and keep what no other is better than."""
        values = np.array([self._list_objectives(one) for one in evaluations])
        self._population.set("F", values)
        self._optimiser.tell(infills=self._population)
        found = np.flatnonzero((values < FORBIDDEN).all(axis=1))
        rows, points = np.append(self._front, first + found), np.vstack([self._values, values[found]])
        # Whether the second of two is as good as the first in every objective; of equal ones the first is kept.
        as_good = reduce(np.logical_and, (column <= column[:, None] for column in points.T))
        best = ~(as_good & (~as_good.T | np.tri(len(rows), k=-1, dtype=bool))).any(axis=1)
        self._front, self._values = rows[best], points[best]

    def collect_results(self) -> Mapping[str, Result]:
        """Return the front: the evaluations that no other is better than in every objective."""
        columns = {"evaluation": self._front, **dict(zip(self._names, (self._values * self._signs).T, strict=True))}
        meaning = "Feasible flights than which no other is better in every objective."
        return {"front": Result(meaning, columns, self._names[:2] if len(self._names) > 1 else ())}

    def _list_objectives(self, evaluation: Evaluation) -> FloatArray:
        """Return the objectives, less is better; what never happened, such as an arrival, is not feasible."""
        missed = sum(evaluation.violations.values())
        if evaluation.failure is not None or missed:
            return np.full(len(self._names), FORBIDDEN + (missed or 1.0))
        found = self._signs * self.read_values(evaluation, self._names, "objectives")
        return found if np.isfinite(found).all() else np.full(len(found), FORBIDDEN)

    def _make_optimiser(self) -> Any:
        """Return a new algorithm of pymoo, which is imported only here: that takes a second."""
        from pymoo.core.problem import Problem
        from pymoo.core.termination import NoTermination

        o, genes, seed = self.options, len(self.space.grammar.list_genes()), int(self.space.rng.integers(2**31))
        kind = "moo" if o.algorithm in MANY else "soo.nonconvex"
        make = getattr(import_module(f"pymoo.algorithms.{kind}.{o.algorithm}"), o.algorithm.upper())
        given: dict[str, Any] = {"pop_size": o.population}
        if o.algorithm == "cmaes":
            given = {"x0": np.full(genes, 0.5), "sigma": 0.2, "popsize": o.population}
        elif o.algorithm == "nsga3":
            from pymoo.util.ref_dirs import get_reference_directions

            given["ref_dirs"] = get_reference_directions("energy", len(o.objectives), o.population, seed=1)
        algorithm, problem = make(**given), Problem(n_var=genes, n_obj=len(o.objectives), xl=0.0, xu=1.0)
        algorithm.setup(problem, termination=NoTermination(), seed=seed, verbose=False)
        return algorithm
