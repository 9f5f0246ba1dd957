"""The numbers that the pages tell of random agents: 2000 genotypes of the default study, and of alternatives."""

import numpy as np
import pytest

from driftform.motion.forces.inertia import added_mass_at, rigid_body_mass
from driftform.study import load_study

COUNT = 2000


def facts(*settings):
    """Columns over the same 2000 random genotypes."""
    pipeline, rng = (load_study("paper", settings=settings, run={"seed": 0}).make_pipeline(), np.random.default_rng(1))
    density = pipeline.scenario.fluid.density
    rows = []
    for _ in range(COUNT):
        agent = pipeline.make_agent(pipeline.grammar.random(rng))
        morphology, mass = agent.morphology, agent.mass
        assert morphology is not None
        ratio = np.linalg.solve(rigid_body_mass(mass), added_mass_at(agent.coefficients, np.zeros(3)))
        rows.append(
            (
                len(morphology.modules),
                density * mass.volume / mass.mass - 1,
                np.linalg.eigvals(ratio).real.max(),
                not (morphology.fore and morphology.aft),
                agent.body.max_diameter,
                agent.body.max_diameter > agent.body.length,
            )
        )
    names = ("modules", "net", "lambda_max", "one_sided", "diameter", "wide")
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


def flat(text):
    return " ".join(text.split())


def percent(share):
    return f"{100 * np.mean(share):.0f} %"


@pytest.fixture(scope="module")
def default():
    return facts()


def test_the_default_study(default, pages):
    notes, physics = flat(pages["paper-notes.md"]), flat(pages["physics.md"])
    low, median, high = np.percentile(default["net"], [5, 50, 95])
    assert set(default["modules"]) == {39}
    assert f"{percent(default['net'] > 0)} float with `first`" in notes
    assert f"And {percent(default['one_sided'])} of random agents have modules on one side only" in notes
    assert f"the median {median:+.2f} among random agents (5 % are below {low:.2f}, 5 % above {high:+.1f})" in notes
    assert f"{np.sum(np.abs(default['net']) < 0.01)} of the 2000 are within 1 % of neutral" in notes
    assert f"instead of {default['diameter'].max():.2f} m" in notes
    assert not default["wide"].any()
    assert f"Of 2000 random agents in `paper`, {percent(default['lambda_max'] > 17 / 3)} lie" in physics


def test_where_places_are_skipped(default, pages):
    notes, found = flat(pages["paper-notes.md"]), facts("grammar.occupied=skip")
    modules = found["modules"]
    assert (
        f"have {np.median(modules):.0f} modules in the median ({modules.min():.0f} to {modules.max():.0f} among 2000), "
        f"and most are heavy: {percent(found['net'] > 0)} float instead of {percent(default['net'] > 0)}"
    ) in notes
    assert f'with `grammar.occupied = "skip"` {percent(found["wide"])} are' in notes


def test_tilts_against_the_neighbour(pages):
    notes, found = flat(pages["paper-notes.md"]), facts("grammar.tilt_reference=neighbour")
    assert f"the largest diameter is then {found['diameter'].max():.2f} m" in notes
    assert f"{percent(found['wide'])} are wider than long" in notes


def test_one_to_thirty_nine_modules_by_construction():
    study = load_study("paper", settings=["grammar.occupied=skip"], run={"seed": 0})
    grammar = study.make_plugin("grammar")
    for move, modules in (("moveN", 1), ("moveF", 39)):
        rule = "-".join([f"addF-tiltp-0-S-{move}"] * 3)
        genome = grammar.parse(" | ".join(f"{letter}: {rule}" for letter in "CSML"))
        assert len(grammar.express(genome).modules) == modules
