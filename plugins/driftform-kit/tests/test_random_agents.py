"""What driftform exports passes its own checks: no false alarms on random agents, sealed and as kits."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from driftform.interfaces import ExportJob, PrintJob
from driftform.study import load_study
from driftform.types import State
from driftform_frusta.hull import hull_volume
from driftform_kit.checks.mesh import MeshChecker, MeshOptions

# What it stands on, and whether it fits a bed, is for the agent to decide.
OURS = ("unit", "duplicate faces", "closed", "oriented", "shells", "mass", "wall")


def look_at(folder: Path, occupied: str, seed: int, kit: bool) -> None:
    study = load_study("paper", settings=[f"grammar.occupied={occupied}", f"exporter.3mf.kit={str(kit).lower()}"])
    pipeline, rng = study.make_pipeline(), np.random.default_rng(seed)
    agent = pipeline.make_agent(pipeline.grammar.random(rng))
    job = ExportJob(f"agent-{seed}", agent, study.scenario)
    written, *_ = study.make_exporter("3mf").write(job, folder / f"agent-{seed}.3mf")
    volume = written.facts["volume_mm3"] * 1e-9 if kit else hull_volume(agent.body)
    job = PrintJob((Path(written.path),), export=job, volume=volume)
    found = list(MeshChecker(MeshOptions()).check(job))
    # A rabbet is cut out of the wall's thickness: it has one line of the nozzle, and that is told.
    allowed = {"wall": State.WARN} if kit else {}
    amiss = [f for f in found if f.check in OURS and f.state not in (State.PASS, allowed.get(f.check))]
    assert amiss == []
    assert Counter(f.check for f in found)["mass"] == 1


@pytest.mark.parametrize("kit", [False, True])
def test_a_random_agent_has_nothing_amiss(tmp_path: Path, kit: bool) -> None:
    look_at(tmp_path, "insert", 1, kit)
