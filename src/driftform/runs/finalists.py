"""The last round of a run: the best agents flown again under disturbed conditions, and who wins then."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from driftform.execution import Executor, Job
from driftform.runs.agent_file import StoredAgent
from driftform.runs.search import check_fitness
from driftform.runs.store import DisturbedResult, Store
from driftform.scenario import evaluation_seed
from driftform.scenario.disturbances import choose_finalists, measure_spread, robust_fitness
from driftform.study import Study
from driftform.types import FloatArray


def fly_finalists(
    study: Study,
    store: Store,
    executor: Executor,
    on_flights: Callable[[int, int], None] = lambda _, __: None,
) -> None:
    """Fly the best of a run for each target under every disturbed condition, and store what they score.

    Where the scenario has no such conditions nothing is flown, and what is stored already is not flown again.
    ``on_flights`` is called with the number of flights that are done, and of all.
    """
    robustness, targets = study.scenario.robustness, study.scenario.target_names
    if not robustness.conditions:
        return
    sound = [brief for brief in store.read_summaries(targets) if not brief.failed]
    chosen = choose_finalists(
        np.array([b.fitness for b in sound]).reshape(-1, len(targets)), robustness.finalists
    )
    wanted = [(sound[row].index, c) for row in chosen for c in range(robustness.conditions)]
    done = store.list_disturbed()
    missing = [pair for pair in wanted if pair not in done]
    genomes = {index: store.read_record(index, targets).candidate.genome for index in {i for i, _ in missing}}
    jobs = [
        Job(number, genomes[index], evaluation_seed(study.seed, index), condition)
        for number, (index, condition) in enumerate(missing)
    ]
    count = len(wanted) - len(missing)
    on_flights(count, len(wanted))
    for arrived in executor.evaluate(jobs):
        store.add_disturbed(
            [
                DisturbedResult(*missing[number], checked.fitness, checked.failure)
                for number, checked in ((n, check_fitness(e, targets)) for n, e in arrived)
            ],
            targets,
        )
        count += len(arrived)
        on_flights(count, len(wanted))


@dataclass(frozen=True, eq=False)
class Winner:
    """The best finalist for a target: its evaluation's ``index``, its robust ``fitness``, and its flights' fitness (n,)."""

    index: int
    fitness: float
    flights: FloatArray
    failed: int

    def document(self) -> dict[str, Any]:
        """What an agent file and a JSON document hold of it."""
        spread = measure_spread(self.flights[:, None], self.failed)
        return {
            "conditions": spread.count,
            "failed": spread.failed,
            "score": self.fitness,
            "mean": float(spread.mean[0]),
            "quantile_10": float(spread.tenth[0]),
            "worst": float(spread.worst[0]),
        }


def find_winner(study: Study, store: Store, target: str) -> Winner | None:
    """Return who won the last round for a target, the earliest of equals; ``None`` where none was flown to its end."""
    robustness = study.scenario.robustness
    found: Winner | None = None
    for index, flights, failed in store.read_disturbed(target):
        if len(flights) < robustness.conditions:
            continue
        fitness = float(robust_fitness(flights[:, None], robustness)[0])
        if found is None or fitness > found.fitness:
            found = Winner(index, fitness, flights, failed)
    return found


def find_best_agent(study: Study, store: Store, target: str) -> StoredAgent | None:
    """The best agent of a run for a target, named after it; ``None`` where no evaluation is sound yet.

    Where finalists were flown under disturbed conditions it is the one that won then.
    """
    best, last_round = store.find_best(target), find_winner(study, store, target)
    if best is None:
        return None
    index, fitness = best
    record = store.read_record(index if last_round is None else last_round.index, study.scenario.target_names)
    result: dict[str, Any] = {
        "target": target,
        "fitness": fitness,
        "error_percent": 100 - fitness,
        "evaluation": index,
    }
    if last_round is not None:
        fitness = float(record.evaluation.fitness[study.scenario.target_names.index(target)])
        result |= {"fitness": fitness, "error_percent": 100 - fitness, "evaluation": last_round.index}
        result["robust"] = last_round.document()
    return StoredAgent(target, record.candidate.genome, study.environment(record.index), result)
