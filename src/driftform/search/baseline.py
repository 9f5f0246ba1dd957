"""The baseline of each target: the plain body of the builder, printed, weighed and tuned for it in the same way as what a run found.

What a shape is worth is the difference to it. It is an agent as any other: its genome is the one without modules.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from driftform.agent import mass_properties
from driftform.pipeline import Pipeline
from driftform.plugins.faults import CAUGHT
from driftform.plugins.genome_text import write_genome
from driftform.runs.store import Store
from driftform.search.jobs import Job
from driftform.search.pool import Executor
from driftform.study import Study
from driftform.types import Genome
from driftform.water.disturbances import Condition, Specimen

SPEEDS = tuple(np.linspace(-0.8, 0.8, 17).tolist())
"""Terminal speeds that are tried first, over the speed of the water; positive sinks."""

HALVINGS = 5
"""How often the distance between two of them is halved, about the best: to 0.003 of the speed of the water."""

STILL = 0.3
"""The same speed in water at rest, m/s: a sphere of 60 mm that weighs 4 % of what it displaces sinks as fast."""

DRAG = 0.4
"""Coefficient by which a terminal speed becomes a net weight; it only spaces the weights that are tried."""

FACTS = "plain bodies"
"""Name by which a store holds them."""


@dataclass(frozen=True)
class Baseline:
    """A plain body that was tuned for a target.

    Attributes:
        genome: tuned.
        text: the same, as ``driftform inspect`` and others take it.
        diameter, length: m.
        net_weight: in water, kg, positive if it sinks.
    """

    genome: Genome
    text: str
    diameter: float
    length: float
    net_weight: float

    @property
    def kind(self) -> str:
        """What it is, in words."""
        if self.length <= 1.001 * self.diameter:
            return f"sphere of {1000 * self.diameter:.3g} mm"
        return f"capsule of {1000 * self.diameter:.3g} x {1000 * self.length:.3g} mm"

    def document(self) -> dict[str, Any]:
        """Return what an agent file and a JSON document hold of it, in SI units."""
        sizes = {"diameter": self.diameter, "length": self.length, "net_weight": self.net_weight}
        return {"kind": self.kind, "genome": self.text, **sizes}


def tune_baselines(study: Study, executor: Executor, targets: Sequence[int]) -> dict[int, Baseline]:
    """Return the baseline by the number of each target; none where no plain body floats the core, or can be tuned."""
    scenario, speed = study.scenario, abs(study.scenario.flow.speed) or STILL
    tune = _find_tuning(study.make_pipeline())
    if tune is None:
        return {}
    calibration = scenario.calibration
    values = calibration.draw_factors(np.zeros((1, len(calibration.intervals))))[0].tolist()
    calm = Condition(calibrated=tuple(values), specimen=Specimen.BASELINE)
    found: dict[int, tuple[float, float, float]] = {}
    step = SPEEDS[1] - SPEEDS[0]
    for level in range(1 + HALVINGS):
        near = step / 2**level
        tried = [
            (target, share)
            for target in targets
            if not level or target in found
            for share in (SPEEDS if not level else (found[target][2] - near, found[target][2] + near))
        ]
        jobs = [Job(number, tune(share * speed).genome, None, calm) for number, (_, share) in enumerate(tried)]
        for arrived in executor.evaluate(jobs):
            for number, evaluation in arrived:
                target, share = tried[number]
                # The order of arrival does not count: of equals it is the slowest.
                better = (float(evaluation.fitness[target]), -abs(share), share)
                if evaluation.failure is None and (target not in found or better > found[target]):
                    found[target] = better
    return {target: tune(share * speed) for target, (_, _, share) in found.items()}


def read_baselines(store: Store) -> dict[int, Baseline]:
    """Return the baselines of a run, by number of target; none before they are tuned, or in a run of an earlier version."""
    rows = store.read_facts(FACTS).get("all", [])
    genomes = [Genome(**g | {"symbols": tuple(g["symbols"])}) for g in (row["baseline"]["genome"] for row in rows)]
    return {row["target"]: Baseline(**row["baseline"] | {"genome": g}) for row, g in zip(rows, genomes, strict=True)}


def find_baselines(study: Study, store: Store, executor: Executor, targets: Sequence[int]) -> dict[int, Baseline]:
    """Return the baselines of a run for some targets, by number; those that it lacks are tuned and stored."""
    baselines = read_baselines(store)
    missing = [target for target in targets if target not in baselines]
    baselines |= tune_baselines(study, executor, missing) if missing else {}
    rows = [{"target": target, "baseline": asdict(baseline)} for target, baseline in baselines.items()]
    store.write_facts(FACTS, {"all": rows})
    return {target: baselines[target] for target in targets if target in baselines}


def _find_tuning(pipeline: Pipeline) -> Callable[[float], Baseline] | None:
    """Return the plain body by the speed at which it should sink, m/s: its net weight is rho C_D A w^2 / 2, within what it can have."""
    fluid, genome = pipeline.scenario.fluid, pipeline.grammar.plain()

    def weigh(genome: Genome) -> Baseline:
        body = pipeline.build(pipeline.express(genome))
        mass, text = mass_properties(body), write_genome(pipeline.grammar, genome)
        return Baseline(genome, text, body.max_diameter, body.length, mass.mass - fluid.density * mass.volume)

    try:
        bounds = None if genome is None else pipeline.builder.find_tunings(pipeline.express(genome))
        if genome is None or bounds is None:
            return None
        light, heavy = (weigh(replace(genome, tuning=at)) for at in bounds)
    except CAUGHT:
        return None

    def tune(sinking: float) -> Baseline:
        area = np.pi / 4 * light.diameter * (light.diameter + 4 / np.pi * (light.length - light.diameter))
        asked = fluid.density * DRAG * area * sinking * abs(sinking) / (2 * (fluid.gravity or 1.0))
        at = np.interp(asked, [light.net_weight, heavy.net_weight], bounds)
        return weigh(replace(genome, tuning=float(at)))

    return tune
