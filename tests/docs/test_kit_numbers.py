"""The numbers that docs/printing.md tells of the kits of random agents."""

import re

import numpy as np

from driftform.study import load_study


def test_of_a_hundred_random_agents(pages: dict[str, str]) -> None:
    from driftform_frusta.kit_options import PartOptions
    from driftform_kit.cutting.pieces import make_kit

    pipeline, rng = load_study("paper", run={"seed": 0}).make_pipeline(), np.random.default_rng(1)
    options = PartOptions(kit=True)
    places = []
    for _ in range(100):
        joint = make_kit(pipeline.make_agent(pipeline.grammar.random(rng)).body, options).core_joint
        if joint.kind == "sleeve":
            places.append(abs(joint.z))
    page = re.sub(r"\s+", " ", pages["printing.md"])
    assert f"{min(places):.0f} to {max(places):.0f} mm, on a side that stays as wide as the core" in page
