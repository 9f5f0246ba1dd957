"""Bodies as the default study makes them."""

import numpy as np
import pytest

from driftform.study import load_study


@pytest.fixture(scope="session")
def random_bodies():
    """Bodies of random genomes of the default study: how many, and the seed."""
    pipeline = load_study("paper").make_pipeline()

    def drawn(count, seed):
        rng = np.random.default_rng(seed)
        return [pipeline.builder.build(pipeline.express(pipeline.grammar.random(rng))) for _ in range(count)]

    return drawn
