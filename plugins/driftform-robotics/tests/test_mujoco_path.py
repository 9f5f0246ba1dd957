"""What an export says of an agent's path in MuJoCo: against MuJoCo itself, and against driftform's own flight."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from driftform.interfaces import ExportJob
from driftform.study import Study
from driftform.types import Coefficients
from driftform_robotics.models.link import make_link
from driftform_robotics.models.mujoco_path import Paths, compare_paths

SEEDS = (9, 12, 14)
"""Random agents, of which some sink in water and rise in MuJoCo."""


@pytest.fixture(scope="module")
def drifting(study: Study) -> list[ExportJob]:
    pipeline, rng = study.make_pipeline(), np.random.default_rng(0)
    agents = [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(24)]
    return [ExportJob(f"agent-{seed}", agent, study.scenario) for seed, agent in enumerate(agents)]


def compare(job: ExportJob) -> Paths:
    return compare_paths(job, make_link(job))


@pytest.mark.parametrize("seed", SEEDS)
def test_its_heights_are_those_that_mujoco_computes(
    seed: int, drifting: list[ExportJob], export: Callable[..., Path]
) -> None:
    job = drifting[seed]
    paths = compare(job)
    model = mujoco.MjModel.from_xml_path(str(export("mjcf", job) / "agent.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    start = data.qpos[:3].copy()
    for _ in range(round(paths.seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    found = data.qpos[:3] - start - data.time * job.scenario.current()
    # Its ellipsoid has another added inertia in pitch than the agent: a few percent.
    assert paths.mujoco[2] == pytest.approx(found[2], rel=0.05, abs=0.02)
    assert paths.mujoco[0] == pytest.approx(found[0], rel=0.05, abs=0.15)


def test_a_file_warns_of_an_agent_that_sinks_in_water_and_rises_in_mujoco(
    drifting: list[ExportJob], export: Callable[..., Path], make_exporter: Callable[..., Any], tmp_path: Path
) -> None:
    job = drifting[9]
    paths = compare(job)
    assert paths.true[2] < -0.9 and paths.mujoco[2] > 0.1 and paths.differ_in_kind
    text = (export("mjcf", job) / "agent.xml").read_text(encoding="utf-8")
    sentence = "this agent has sunk by 1 m; in MuJoCo it has risen by 0.14 m"
    assert sentence in text and "MUJOCO'S PATH DIFFERS IN KIND" in text
    [scene, *_] = make_exporter("mjcf").write(job, tmp_path / "again-mjcf")
    assert sentence in str(scene.facts["warnings"])


def test_three_of_24_random_agents_move_in_another_way_in_mujoco(drifting: list[ExportJob]) -> None:
    """As docs/robotics.md states."""
    paths = [compare(job) for job in drifting]
    different = [path for path in paths if path.differ_in_kind]
    assert len(different) == 3
    assert sum(path.true[2] < -0.9 and path.mujoco[2] > 0 for path in different) == 2


@pytest.mark.parametrize(
    ("true", "mujoco", "differs"),
    [
        (-1.0, 0.2, True),
        (1.0, 0.05, True),
        (0.02, 1.0, True),
        (1.0, 1.9, False),
        (-0.5, -0.9, False),
        (0.0, 0.0, False),
    ],
)
def test_a_path_differs_in_kind_if_it_rises_sinks_or_stays_where_the_other_does_not(
    true: float, mujoco: float, differs: bool
) -> None:
    paths = Paths(0.5, np.array([0.1, 0.0, true]), np.array([-0.2, 0.0, mujoco]))
    assert paths.differ_in_kind == differs
    assert ("DIFFERS IN KIND" in paths.describe()) == differs


def test_an_agent_as_light_as_foam_is_compared_within_seconds(drifting: list[ExportJob]) -> None:
    job = drifting[12]
    mass = replace(job.agent.mass, mass=1e-3 * job.agent.mass.mass, inertia=1e-3 * job.agent.mass.inertia)
    started = time.process_time()
    paths = compare(replace(job, agent=replace(job.agent, mass=mass)))
    assert np.isfinite(paths.mujoco).all() and 0 < paths.seconds < 3
    assert time.process_time() - started < 30


def test_an_agent_without_added_mass_has_the_same_path_in_both(drifting: list[ExportJob]) -> None:
    job = drifting[12]
    bare = Coefficients(np.zeros((6, 6)), job.agent.coefficients.origin)
    paths = compare(replace(job, agent=replace(job.agent, coefficients=bare)))
    assert paths.apart < 1e-4 and "wrong by" in paths.describe()
