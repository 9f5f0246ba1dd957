"""The job of docs/running.md, with a stand-in for SLURM: one that is preempted goes on where it was."""

import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

STUDY = """base = "paper"
simulator.use = "fake"
simulator.pause = 0.05
strategy.use = "random"
run.evaluations = 60
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="a script of bash, and /proc")
def test_a_job_that_is_preempted_ends_like_one_that_was_not(fake_plugin, rows, tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "running.md").read_text(encoding="utf-8")

    def count(run):
        with suppress(sqlite3.OperationalError):
            # Reading would make the file.
            return len(rows(run)) if (run / "run.db").exists() else 0
        return 0

    [job] = re.findall(r"```bash\n(.*?)```", page, re.DOTALL)
    (tmp_path / "job.sh").write_text(job, encoding="utf-8")
    (tmp_path / "srun").write_text('#!/bin/sh\nexec "$@"\n', encoding="utf-8")
    (tmp_path / "srun").chmod(0o755)
    for name, times in (("preempted", 2), ("whole", 1)):
        (submit := tmp_path / name).mkdir()
        (submit / "my-study.toml").write_text(STUDY, encoding="utf-8")
        for k in range(times):
            (disk := tmp_path / f"{name}-{k}").mkdir()
            variables = {
                "SLURM_SUBMIT_DIR": submit,
                "SLURM_ARRAY_TASK_ID": 3,
                "TMPDIR": disk,
                "PYTHONPATH": fake_plugin,
            }
            path = f"{tmp_path}:{Path(sys.executable).parent}:{os.environ['PATH']}"
            environment = os.environ | {key: str(value) for key, value in variables.items()} | {"PATH": path}
            with subprocess.Popen(["bash", tmp_path / "job.sh"], cwd=submit, env=environment) as process:
                while k + 1 < times and count(disk / "r3") < 3:
                    assert process.poll() is None
                    time.sleep(0.1)
                if k + 1 < times:
                    # To the step alone, as SLURM does; the script then has time to copy what there is.
                    [step] = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
                    os.kill(int(step), signal.SIGTERM)
            assert process.returncode == 0
    assert rows(tmp_path / "preempted" / "r3") == rows(tmp_path / "whole" / "r3")
