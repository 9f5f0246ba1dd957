"""``driftform sample``."""

from types import SimpleNamespace

from driftform.cli.options import FILE, declare


@declare(FILE, "out", "count", "seed", "scenario", "settings", "json")
def sample(given: SimpleNamespace) -> None:
    """Make random agents, each an agent.json."""
    import numpy as np

    from driftform.cli.output import print_json
    from driftform.errors import find_commonest
    from driftform.runs.agent_file import StoredAgent
    from driftform.study import load_study
    from driftform.util.files import check_new_directory, make_directory

    study = load_study(given.scenario, given.settings or ())
    check_new_directory(given.out)
    pipeline = study.make_pipeline()
    grammar = pipeline.grammar
    make_directory(given.out)
    rng = np.random.default_rng(given.seed)
    environment = study.environment()
    width = max(4, len(str(given.count)))
    paths: list[str] = []
    reasons: list[str] = []
    for number in range(1, given.count + 1):
        name = f"agent-{number:0{width}d}"
        genome = grammar.random(rng)
        StoredAgent(name, genome, environment, {"seed": given.seed}).write(given.out / f"{name}.json")
        paths.append(str(given.out / f"{name}.json"))
        if isinstance(reason := pipeline.try_build(genome), str):
            reasons.append(reason)
    commonest, alike = find_commonest(reasons)
    if given.json:
        failure = {"reason": commonest, "count": alike} if reasons else None
        print_json({"agents": paths, "seed": given.seed, "failed": len(reasons), "commonest_failure": failure})
        return
    print(
        f"{given.count} random agents, seed {given.seed}: {paths[0]} ... {paths[-1]}" if given.count > 1 else paths[0]
    )
    if reasons:
        print(f"{len(reasons)} of {given.count} cannot be released, {alike} of them like this: {commonest}")
