"""The baseline of each target: the plainest body, printed, weighed and tuned for it in the same way as what a run found.

What a shape is worth is the difference to it. It is as wide as the port lets in, since what remains of errors in net weight counts
least in the largest; without a port it has the volume of the winner. Its net weight is that of the best undisturbed flight.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from driftform.agent import mass_properties
from driftform.agent.plain import PlainBody, find_size
from driftform.runs.store import Store
from driftform.search.jobs import Executor, Job
from driftform.study import Study
from driftform.types import Body, Genome
from driftform.water.disturbances import Condition, Specimen

SPEEDS = tuple(np.linspace(-0.8, 0.8, 17).tolist())
"""Terminal speeds that are tried first, over the speed of the water; positive sinks."""

HALVINGS = 5
"""How often the distance between two of them is halved, about the best: to 0.003 of the speed of the water."""

STILL = 0.3
"""The same speed in water at rest, m/s: a sphere of 60 mm that weighs 4 % of what it displaces sinks as fast."""

DRAG = 0.4
"""Coefficient by which a terminal speed becomes a net weight; it only spaces the weights that are tried."""

FACTS = "baselines"
"""Name by which a store holds them."""


@dataclass(frozen=True)
class Aim:
    """A target by its number, and the winner for it: its genome and its body."""

    target: int
    genome: Genome
    body: Body


def tune_baselines(study: Study, executor: Executor, aims: Sequence[Aim]) -> dict[int, PlainBody]:
    """Return the baseline by the number of the target; without it where no plain body floats the core, or none could fly."""
    scenario, speed = study.scenario, abs(study.scenario.flow.speed) or STILL
    density = scenario.fluid.density
    sizes = {aim: _choose_size(aim.body, density, scenario.release.port) for aim in aims}
    found: dict[int, tuple[float, float, float]] = {}
    step = SPEEDS[1] - SPEEDS[0]
    for level in range(1 + HALVINGS):
        tried = [
            (aim, size, share)
            for aim, size in sizes.items()
            if size is not None
            for share in (SPEEDS if not level else _list_neighbours(found, aim.target, step / 2**level))
        ]
        jobs = [
            Job(
                number,
                aim.genome,
                None,
                _make_calm(study, _weigh(size, share * speed, density, scenario.fluid.gravity)),
            )
            for number, (aim, size, share) in enumerate(tried)
        ]
        for arrived in executor.evaluate(jobs):
            for number, evaluation in arrived:
                aim, _, share = tried[number]
                # The order of arrival does not count: of equals it is the slowest.
                better = (float(evaluation.fitness[aim.target]), -abs(share), share)
                if evaluation.failure is None and (aim.target not in found or better > found[aim.target]):
                    found[aim.target] = better
    return {
        aim.target: _weigh(size, found[aim.target][2] * speed, density, scenario.fluid.gravity)
        for aim, size in sizes.items()
        if size is not None and aim.target in found
    }


def read_baselines(store: Store) -> dict[tuple[int, int], PlainBody]:
    """Return the baselines of a run, by numbers of target and winner; none before they are tuned, or in a run of an earlier version."""
    return {(row["target"], row["winner"]): PlainBody(**row["plain"]) for row in store.read_facts(FACTS).get("all", [])}


def write_baselines(store: Store, baselines: Mapping[tuple[int, int], PlainBody]) -> None:
    """Store the baselines of a run, by numbers of target and winner."""
    rows = [{"target": t, "winner": w, "plain": asdict(plain)} for (t, w), plain in baselines.items()]
    store.write_facts(FACTS, {"all": rows})


def _choose_size(like: Body, density: float, port: float) -> PlainBody | None:
    return find_size(like, density, port or float(np.cbrt(6 * mass_properties(like).volume / np.pi)))


def _weigh(size: PlainBody, sinking: float, density: float, gravity: float) -> PlainBody:
    """Return the body with the net weight (kg) that makes it sink at a speed, m/s: rho C_D A w^2 / 2."""
    area = np.pi / 4 * size.diameter * (size.diameter + 4 / np.pi * (size.length - size.diameter))
    return replace(size, net_weight=float(density * DRAG * area * sinking * abs(sinking) / (2 * (gravity or 1.0))))


def _list_neighbours(found: Mapping[int, Sequence[float]], target: int, step: float) -> tuple[float, ...]:
    return (found[target][2] - step, found[target][2] + step) if target in found else ()


def _make_calm(study: Study, plain: PlainBody) -> Condition:
    """Return the condition of an undisturbed flight of a plain body."""
    calibration = study.scenario.calibration
    values = calibration.draw_factors(np.zeros((1, len(calibration.intervals))))[0].tolist()
    return Condition(calibrated=tuple(values), specimen=Specimen.BASELINE, plain=plain)
