"""Bodies as the default study makes them."""

from collections.abc import Callable

import numpy as np
import pytest

from driftform.study import load_study
from driftform.types import Body


@pytest.fixture(scope="session")
def random_bodies() -> Callable[[int, int], list[Body]]:
    """Bodies of random genomes of the default study: how many, and the seed."""
    pipeline = load_study("pipe-inspection").pipeline()

    def drawn(count: int, seed: int) -> list[Body]:
        rng = np.random.default_rng(seed)
        return [
            pipeline.builder.build(pipeline.express(pipeline.grammar.random(rng))) for _ in range(count)
        ]

    return drawn
