"""Drake's parser, which reads SDF up to 1.12 with the elements of its specification, and refuses others."""

import logging
import re
import sys
from importlib import import_module

import numpy as np
import pytest

if sys.platform == "win32":
    pytest.skip("Drake has no wheel for Windows", allow_module_level=True)
parsing = import_module("pydrake.multibody.parsing")

UNSUPPORTED = {"cast_shadows", "gravity", "light", "physics", "plugin", "scene", "transparency"}
"""Sound elements that Drake has no use for."""


def parse(path):
    """Mass, COG and inertia about it of the agent's link, as Drake has them."""
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    parser = parsing.Parser(plant)
    parser.AddModels(str(path))
    plant.Finalize()
    body = plant.GetBodyByName("base_link")
    inertia = body.default_spatial_inertia().Shift(body.default_com()).CalcRotationalInertia()
    return body.default_mass(), body.default_com(), inertia.CopyToFullMatrix3()


@pytest.mark.parametrize("name", ["model.sdf", "world.sdf", "drift.sdf"])
def test_it_reads_the_mass_the_centre_and_the_inertia(name, job, export, caplog):
    with caplog.at_level(logging.WARNING):
        mass, cog, inertia = parse(export("sdf", job) / name)
    expected = job.agent.mass
    assert mass == pytest.approx(expected.mass, rel=1e-10)
    np.testing.assert_allclose(cog, 0, atol=1e-15)
    np.testing.assert_allclose(inertia, expected.inertia, rtol=1e-9, atol=1e-9 * expected.inertia.max())
    ignored = {
        re.search(r"nsupported (?:value for )?SDFormat element (?:in \w+: )?(\w+)", r.message) for r in caplog.records
    }
    assert None not in ignored, caplog.text
    assert {match[1] for match in ignored} <= UNSUPPORTED
