"""The job of docs/running.md, with a stand-in for SLURM: one that is preempted goes on where it was."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from processes import count_evaluations, wait_until

PAGE = Path(__file__).parents[2] / "docs" / "running.md"
STUDY = """base = "paper"
simulator.use = "fake"
simulator.pause = 0.05
strategy.use = "random"
run.evaluations = 60
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="a script of bash, and /proc")
def test_a_job_that_is_preempted_ends_like_one_that_was_not(fake_plugin, rows, tmp_path):
    [job] = re.findall(r"```bash\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "job.sh").write_text(job, encoding="utf-8")
    (tmp_path / "srun").write_text('#!/bin/sh\nexec "$@"\n', encoding="utf-8")
    (tmp_path / "srun").chmod(0o755)
    for name, times in (("preempted", 2), ("whole", 1)):
        (submit := tmp_path / name).mkdir()
        (submit / "my-study.toml").write_text(STUDY, encoding="utf-8")
        for k in range(times):
            (disk := tmp_path / f"{name}-{k}").mkdir()
            path = f"{tmp_path}:{Path(sys.executable).parent}:{os.environ['PATH']}"
            slurm = {"SLURM_SUBMIT_DIR": str(submit), "SLURM_ARRAY_TASK_ID": "3", "TMPDIR": str(disk), "PATH": path}
            environment = os.environ | {"PYTHONPATH": str(fake_plugin)} | slurm
            with subprocess.Popen(["bash", tmp_path / "job.sh"], cwd=submit, env=environment) as process:
                if k + 1 < times:
                    wait_until(lambda run=disk / "r3": count_evaluations(run) > 2)
                    # To the step alone, as SLURM does; the script then has time to copy what there is.
                    [step] = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
                    os.kill(int(step), signal.SIGTERM)
            assert process.returncode == 0
    assert rows(tmp_path / "preempted" / "r3") == rows(tmp_path / "whole" / "r3")
