"""Which bodies are the same."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.agent.identity import body_key
from driftform.types import Core, Module, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions

SHORT, LONG, CONE = Module(0.005, 0.1), Module(0.01, 0.1), Module(0.01, -0.2)
BUILDER = FrustaBuilder(FrustaOptions())
KITS = FrustaBuilder(FrustaOptions(made_as="kit", kit={"bed": (0.25, 0.21, 0.06)}))


@pytest.mark.parametrize("builder", [BUILDER, KITS], ids=["hull", "kit"])
def test_modules_of_equal_tilt_in_another_order_make_the_same_body(builder):
    one, other = (
        builder.build(Morphology((CONE,), aft))
        for aft in ((LONG, SHORT, LONG, CONE), (SHORT, LONG, LONG, CONE))
    )
    assert not np.array_equal(one.joints, other.joints)
    assert body_key(one) == body_key(other)
    assert body_key(one) != body_key(builder.build(Morphology((CONE,), (LONG, CONE, SHORT, LONG))))


def test_a_kit_that_is_cut_elsewhere_is_another_body():
    one, other = (
        KITS.build(Morphology((), aft))
        for aft in ((LONG, SHORT) * 5 + (CONE,), (LONG, LONG, SHORT, SHORT) * 2 + (LONG, SHORT, CONE))
    )
    assert np.allclose(one.outer, other.outer)
    assert body_key(one) != body_key(other)


def test_what_changes_the_weight_makes_another_body():
    body = BUILDER.build(Morphology((LONG,), (CONE,)))
    changes = [
        {"core": Core(body.core.radius, 1.001 * body.core.mass)},
        {"hull_density": 1.001 * body.hull_density},
        {"cavity": body.cavity * (1.0, 0.999)},
        {"fittings": replace(body.fittings, material=replace(body.fittings.material, volume=1e-9))},
        {"ballast": replace(body.ballast, volume=1e-9)},
    ]
    keys = {body_key(body), *(body_key(replace(body, **change)) for change in changes)}
    assert len(keys) == 1 + len(changes)
