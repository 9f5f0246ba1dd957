"""Contract of fittings."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from driftform.agent import hull_mass, mass_properties
from driftform.interfaces import ExportJob, Fitting
from driftform.plugins.registry import registry
from driftform.testing.bodies import hollow_body, mirrored_body
from driftform.testing.contract import AnsweringContract, Question
from driftform.types import Agent, Body, Coefficients, Module, Morphology
from driftform.water import Scenario


class FittingContract(AnsweringContract[Fitting[Any]]):
    """The contract of fittings on the hull of a ``morphology``; ``frusta`` finds them by their names: install the plugin first."""

    morphology = Morphology((Module(0.01, 0.0),) * 6, (Module(0.01, 0.0),) * 6)

    def questions(self) -> Sequence[Question]:
        """Draw it for a tube in either direction."""
        return [("draw", body) for body in (hollow_body(), mirrored_body(hollow_body()))]

    def build(self, *fittings: Fitting[Any]) -> Body:
        """Return the body of the contract's morphology with fittings."""
        chosen = [{"use": one.name, **one.options.model_dump(mode="json")} for one in fittings]
        body: Body = registry().create("builder", "frusta", {"fittings": chosen}).build(self.morphology)
        return body

    def test_a_sealed_hull_with_it_is_printed_as_simulated(self, tmp_path: Path) -> None:
        """It changes mass or volume, leaves the hull sealed and in one piece, and the STL file weighs what the body does."""
        bare, body = self.build(), self.build(self.plugin())
        before, after = mass_properties(bare), mass_properties(body)
        assert (before.mass, before.volume) != (after.mass, after.volume)
        job = ExportJob("fitted", Agent(body, after, Coefficients(np.eye(6))), Scenario())
        [file] = registry().create("exporter", "stl", {}).write(job, tmp_path / "fitted.stl")
        assert file.facts["mass_kg"] == pytest.approx(hull_mass(body), abs=1e-5)
        assert file.facts["shells"] >= 1 + bool(len(body.cavity))
