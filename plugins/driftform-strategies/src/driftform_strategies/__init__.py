"""Search strategies: evolution of tuned bodies and of single symbols, plain bodies, and random search."""

from driftform import hookimpl


@hookimpl
def driftform_strategy() -> list[type]:
    """Return evolution by single symbols, random search, and the searches of tuned bodies."""
    from driftform_strategies.evolution import EvolutionStrategy
    from driftform_strategies.random import RandomStrategy
    from driftform_strategies.tuned import DirectStrategy, TunedStrategy

    return [DirectStrategy, EvolutionStrategy, RandomStrategy, TunedStrategy]
