"""Bodies as the default study makes them, and how tables get into docs/validation.md."""

from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from driftform.study import load_study

# Fixtures of driftform's tests: with the import mode "importlib" a conftest is not importable from another folder.
_TESTS = run_path(str(Path(__file__).parents[3] / "tests" / "conftest.py"))
publish, published = _TESTS["publish"], _TESTS["published"]


@pytest.fixture(scope="session")
def random_bodies():
    """Bodies of random genomes of the default study: how many, and the seed."""
    pipeline = load_study("paper").make_pipeline()

    def drawn(count, seed):
        rng = np.random.default_rng(seed)
        return [pipeline.builder.build(pipeline.express(pipeline.grammar.random(rng))) for _ in range(count)]

    return drawn
