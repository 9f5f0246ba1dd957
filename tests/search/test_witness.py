"""A run as its own witness: what another simulator sees of its winners."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.runs.store import Record
from driftform.search.witness import find_dissent
from driftform.study import load_study
from driftform.types import Candidate


@pytest.mark.parametrize("use", ["native", "exudyn"])
def test_a_winner_that_the_other_simulator_sees_elsewhere_is_named(use):
    study = load_study("pipe-inspection", use={"simulator": use})
    genome = study.make_plugin("grammar").random(np.random.default_rng(1))
    [sound] = study.make_pipeline().evaluate([genome])
    flight = sound.trajectory
    shifted = replace(
        sound, trajectory=replace(flight, position=flight.position + np.array([0.0, 0.0, 0.05]), error=flight.error)
    )

    class Stored:
        def __init__(self, evaluation):
            self.evaluation = evaluation

        def count(self):
            return 100

        def read_record(self, index, targets):
            return Record(index, Candidate(genome), self.evaluation)

    assert find_dissent(study, Stored(sound), [7]) is None
    other = {"native": "exudyn", "exudyn": "native"}[use]
    assert f"1 of 1 winners pass their targets elsewhere by the simulator '{other}'" in find_dissent(
        study, Stored(shifted), [7]
    )
