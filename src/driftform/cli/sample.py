"""``driftform sample``."""

from pathlib import Path
from typing import Annotated

from driftform.cli.options import Json, Settings, make_option


def sample(
    out: Annotated[Path, make_option("DIR", "Directory for the agents.")],
    count: Annotated[int, make_option("N", "Number of agents.", min=1, max=1_000_000)] = 10,
    seed: Annotated[int, make_option("N", "Seed of the random numbers.", min=0)] = 0,
    scenario: Annotated[
        str | None, make_option("NAME|FILE", "Study with the grammar and the builder of the agents.")
    ] = None,
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Make random agents, each an agent.json."""
    import numpy as np

    from driftform.cli.output import print_json
    from driftform.errors import find_commonest
    from driftform.runs.agent_file import StoredAgent
    from driftform.study import load_study
    from driftform.util.files import check_new_directory, make_directory

    study = load_study(scenario, settings or ())
    check_new_directory(out)
    pipeline = study.make_pipeline()
    grammar = pipeline.grammar
    make_directory(out)
    rng = np.random.default_rng(seed)
    environment = study.environment()
    width = max(4, len(str(count)))
    paths: list[str] = []
    reasons: list[str] = []
    for number in range(1, count + 1):
        name = f"agent-{number:0{width}d}"
        genome = grammar.random(rng)
        StoredAgent(name, genome, environment, {"seed": seed}).write(out / f"{name}.json")
        paths.append(str(out / f"{name}.json"))
        if isinstance(reason := pipeline.try_build(genome), str):
            reasons.append(reason)
    commonest, alike = find_commonest(reasons)
    if json:
        failure = {"reason": commonest, "count": alike} if reasons else None
        print_json({"agents": paths, "seed": seed, "failed": len(reasons), "commonest_failure": failure})
        return
    print(f"{count} random agents, seed {seed}: {paths[0]} ... {paths[-1]}" if count > 1 else paths[0])
    if reasons:
        print(f"{len(reasons)} of {count} cannot be released, {alike} of them like this: {commonest}")
