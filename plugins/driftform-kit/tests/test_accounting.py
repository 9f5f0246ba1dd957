"""What a kit weighs against what was simulated, by closed forms and by its meshes."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from prints import chain_body, job_of, weigh_meshes

from driftform.agent import MassElement, mass_properties
from driftform.errors import InputError
from driftform.study import Document, load_study
from driftform.types import Module, Moments, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.kit_options import PartOptions
from driftform_kit.cutting.accounting import kit_mass, weigh_kit
from driftform_kit.cutting.pieces import make_kit
from driftform_kit.kit import list_facts

TILTS = st.sampled_from([-0.3, 0.0, 0.3])
SIDES = st.lists(st.builds(Module, st.sampled_from([0.005, 0.01]), TILTS), max_size=6).map(tuple)
BODIES = st.builds(lambda fore, aft: FrustaBuilder(FrustaOptions()).build(Morphology(fore, aft)), SIDES, SIDES)
STRAIGHT = chain_body("ssss", "sss")


@settings(max_examples=10, deadline=None)
@given(BODIES, st.sampled_from(["auto", "rabbet"]))
def test_the_accounts_are_those_of_the_meshes(body, joint):
    options = PartOptions(kit=True, joint=joint, segments=96)
    mass, cog, inertia = weigh_meshes(body, options)
    stated = kit_mass(body, options)
    assert stated.mass == pytest.approx(mass, rel=1e-6)
    assert stated.cog == pytest.approx(cog, abs=1e-8)
    # A polygon of 96 corners with its circle's area has more polar inertia, by (pi/96)^4 of it.
    assert stated.inertia == pytest.approx(inertia, rel=1e-4, abs=1e-11)


def facts(body, **options):
    return list_facts(job_of(body, gravity=10.0), PartOptions(**options))


def test_facts_compare_what_is_printed_with_what_was_simulated():
    kit = facts(STRAIGHT, kit=True)["kit"]
    simulated, printed = kit["balance"]
    assert (simulated["of"], printed["of"]) == ("simulated", "printed")
    stated, was = kit_mass(STRAIGHT, PartOptions(kit=True)), mass_properties(STRAIGHT)
    assert printed["mass_kg"] == stated.mass
    assert printed["cog_mm"] == 1e3 * stated.cog[0]
    assert printed["net_buoyancy_n"] == pytest.approx(10 * (1000 * stated.volume - stated.mass))
    assert simulated["net_buoyancy_n"] == pytest.approx(10 * (1000 * was.volume - was.mass))
    parts = sum(part["mass_kg"] for part in kit["parts"])
    assert parts + STRAIGHT.core.mass == pytest.approx(stated.mass)
    assert kit["joint"]["kind"] == "sleeve"


def test_a_closed_kit_balances_as_its_agent_also_with_a_core_off_its_centre():
    core = replace(STRAIGHT.core, cog=0.003)
    job = job_of(replace(STRAIGHT, core=core))
    parts = make_kit(job.agent.body, PartOptions(kit=True))
    mass, moment = weigh_kit(job.agent, parts, PartOptions(kit=True)).closed(1.0)
    stated = kit_mass(job.agent.body, PartOptions(kit=True))
    assert (mass, moment) == pytest.approx((stated.mass, stated.mass * stated.cog[0]))


KITS = [
    {},
    {"joint": "rabbet"},
    {"o_ring": 0.0015},
    {"joint": "bayonet"},
    {"joint": "thread"},
    {"bed": (0.25, 0.21, 0.05)},
]


@pytest.mark.parametrize("options", KITS, ids=[" ".join(map(str, kit.values())) or "usual" for kit in KITS])
def test_an_agent_made_as_a_kit_is_simulated_with_the_mass_of_the_meshes_of_its_kit(options):
    morphology = Morphology(
        tuple(Module(0.01, tilt) for tilt in (0.2, 0.0, 0.0, 0.0, 0.0, -0.2)),
        tuple(Module(0.01, tilt) for tilt in (0.2, 0.0, 0.0, 0.0)),
    )
    body = FrustaBuilder(FrustaOptions(made_as="kit", kit=options)).build(morphology)
    simulated = mass_properties(body)
    # Meshes have no O-rings.
    printed = mass_properties(replace(body, fittings=replace(body.fittings, seals=Moments())))
    mass, cog, inertia = weigh_meshes(body, PartOptions(kit=True, segments=128, **options))
    plain = mass_properties(FrustaBuilder(FrustaOptions()).build(morphology))
    assert printed.mass == pytest.approx(mass, rel=1e-6)
    assert printed.cog[0] == pytest.approx(cog[0], abs=1e-8)
    assert printed.inertia == pytest.approx(inertia, rel=1e-4, abs=1e-8)
    assert abs(cog[1]) < 1e-5
    assert simulated.mass - plain.mass > 2e-4
    exported = kit_mass(body, PartOptions(kit=True, **options))
    assert (simulated.mass, simulated.volume) == pytest.approx((exported.mass, exported.volume), rel=1e-12)
    assert (simulated.cog[0], simulated.cob[0]) == pytest.approx((exported.cog[0], exported.cob[0]), abs=1e-12)


def test_a_gram_more_of_an_agent_made_as_a_kit_is_spread_as_its_parts_are():
    agent = job_of(chain_body("sssss", "ss", made_as="kit")).agent
    same = MassElement.reweigh(agent, MassElement.of_print(agent.body, agent.mass.mass)).mass
    assert same.cog == pytest.approx(agent.mass.cog, rel=1e-12)
    assert same.inertia == pytest.approx(agent.mass.inertia, rel=1e-12)


def test_a_study_of_kits_states_how_they_are_cut_and_its_agents_weigh_more():
    settings = ["builder.made_as=kit", "builder.kit.joint=rabbet"]
    study = load_study("paper", settings=settings, run={"seed": 0})
    again = load_study(Document("stored", study.document), run={"seed": 0})
    assert again.document["builder"]["kit"]["lap"] == 0.006
    assert again.document["builder"]["kit"]["joint"] == "rabbet"
    pipeline, plain = again.make_pipeline(), load_study("paper", run={"seed": 0}).make_pipeline()
    genome = plain.grammar.random(np.random.default_rng(5))
    added = pipeline.make_agent(genome).mass.mass - plain.make_agent(genome).mass.mass
    assert 2e-4 < added < 5e-3
    with pytest.raises(InputError, match=r"--set builder.kit.lapp=1: unknown key 'lapp' in \[builder.kit\]"):
        load_study("paper", settings=[*settings, "builder.kit.lapp=1"])


README = Path(__file__).parents[1] / "README.md"


def test_the_example_weighs_a_kit_and_lists_its_parts(capsys):
    [source] = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(source, str(README), "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(" shell")[0] for line in lines if "shell" in line] == ["aft", "fore"]
    assert float(lines[-1]) == pytest.approx(0.0391, abs=5e-5)
