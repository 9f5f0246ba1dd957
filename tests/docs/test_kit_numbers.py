"""The numbers that docs/printing.md tells of the kits of random agents."""

import re

import numpy as np

from driftform.study import load_study


def test_of_a_hundred_random_agents(pages: dict[str, str]) -> None:
    from driftform.agent import mass_properties
    from driftform_frusta.kit_options import PartOptions
    from driftform_kit.cutting.accounting import kit_mass
    from driftform_kit.cutting.pieces import make_kit

    pipeline, rng = load_study("paper", run={"seed": 0}).make_pipeline(), np.random.default_rng(1)
    options = PartOptions(kit=True)
    added, places = [], []
    for _ in range(100):
        body = pipeline.make_agent(pipeline.grammar.random(rng)).body
        added.append(1e3 * (kit_mass(body, options).mass - mass_properties(body).mass))
        joint = make_kit(body, options).core_joint
        if joint.kind == "sleeve":
            places.append(abs(joint.z))
    page = re.sub(r"\s+", " ", pages["printing.md"])
    assert f"{min(places):.0f} to {max(places):.0f} mm, on a side that stays as wide as the core" in page
    assert f"Of 100 random agents {100 * len(places) / 100:.0f} % get a sleeve" in page
    assert f"{np.median(added):.1f} g in the median and {max(added):.1f} g at most" in page
