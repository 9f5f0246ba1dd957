"""What an export says of an agent's path in MuJoCo, against MuJoCo itself."""

import re

import mujoco
import numpy as np
import pytest

from driftform.interfaces import ExportJob
from driftform.study import load_study
from driftform_robotics.models.gap import TIMES, fly_own
from driftform_robotics.models.link import make_link
from driftform_robotics.models.mjcf import MjcfExporter


def test_the_gap_of_ten_agents_is_the_one_that_mujoco_flies(tmp_path):
    study = load_study("pipe-inspection", run={"seed": 0})
    pipeline, rng = study.make_pipeline(), np.random.default_rng(3)
    for seed in range(10):
        job = ExportJob("agent", pipeline.make_agent(pipeline.grammar.random(rng)), study.scenario)
        MjcfExporter(MjcfExporter.Options()).write(job, tmp_path / f"{seed}-mjcf")
        path = tmp_path / f"{seed}-mjcf" / "agent.xml"
        printed = [float(d) for d in re.findall(r"(\S+) m after \d s", path.read_text(encoding="utf-8"))]
        model = mujoco.MjModel.from_xml_path(str(path))
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        link, found = make_link(job), []
        ours = fly_own(job, link, TIMES[-1])
        for time in TIMES:
            while data.time < time - 1e-9:
                mujoco.mj_step(model, data)
            moved = data.qpos[:3] - link.position - time * job.scenario.current()
            found.append(np.linalg.norm(moved - ours[round(time / TIMES[-1] * (len(ours) - 1))]))
        assert printed == pytest.approx(found, rel=0.03, abs=2e-3)
