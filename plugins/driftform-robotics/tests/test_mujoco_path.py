"""What an export says of an agent's path in MuJoCo, against MuJoCo itself."""

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from driftform.interfaces import ExportJob
from driftform.study import Study
from driftform_robotics.models.gap import COMMON_STEP, fly_reader
from driftform_robotics.models.link import make_link
from driftform_robotics.models.mjcf import read_mujoco

SECONDS = 0.6
"""Later the ellipsoid of MuJoCo, which the computed path lacks, matters."""


@pytest.fixture(scope="module")
def drifting(study: Study) -> list[ExportJob]:
    pipeline, rng = study.make_pipeline(), np.random.default_rng(0)
    agents = [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(24)]
    return [ExportJob(f"agent-{seed}", agent, study.scenario) for seed, agent in enumerate(agents)]


@pytest.mark.parametrize("seed", [9, 12])
def test_its_height_is_the_one_that_mujoco_computes(
    seed: int, drifting: list[ExportJob], export: Callable[..., Path]
) -> None:
    job = drifting[seed]
    link = make_link(job)
    model = mujoco.MjModel.from_xml_path(str(export("mjcf", job) / "agent.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    start = data.qpos[2]
    for _ in range(round(SECONDS / model.opt.timestep)):
        mujoco.mj_step(model, data)
    path = fly_reader(read_mujoco(link, job.scenario.fluid.density), job, link, SECONDS, COMMON_STEP)
    # Its ellipsoid has another added inertia in pitch than the agent: a few percent.
    assert path[-1, 2] == pytest.approx(data.qpos[2] - start, rel=0.05, abs=0.02)
