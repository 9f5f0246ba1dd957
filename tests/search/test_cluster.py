"""Runs on a Dask cluster: by address, with workers that join and leave, and errors in one line."""

import json
import shutil
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from processes import count_evaluations, wait_until

from driftform.errors import InputError, WorkFailedError
from driftform.runs.versions import find_versions
from driftform.search import cluster
from driftform.search.cluster import Cluster
from driftform.search.jobs import Job
from driftform.study import load_study

STUDY = (
    *("evolve", "--strategy", "paper", "--simulator", "fake", "--target", "TP1", "--target", "TP8"),
    *("--evaluations", 60, "--seed", 5, "--out", "run"),
)


@pytest.fixture
def study(fakes):
    return load_study("paper", use={"simulator": "fake"}, targets=["TP1"], run={"seed": 1})


def job(study):
    return Job(0, study.make_plugin("grammar").random(np.random.default_rng(1)))


def test_a_run_on_a_cluster_is_the_run_of_one_process(call, fakes, rows, dask_cluster, tmp_path):
    result = call(*STUDY, "--scheduler", dask_cluster)
    assert result.exit_code == 0, result.stderr
    there = rows(tmp_path / "run")
    (tmp_path / "run").rename(tmp_path / "there")
    assert call(*STUDY, "--workers", 1).exit_code == 0
    assert len(there) == 60 + 2 * 60
    assert rows(tmp_path / "run") == there


def test_a_worker_flies_one_genome_at_a_time_however_many_threads_it_has(dask, dask_scheduler, tmp_path, fakes):
    study = load_study(None, ["simulator.pause=0.05"], use={"simulator": "fake"}, targets=["TP1"], run={"seed": 1})
    jobs = [Job(index, job(study).genome) for index in range(20)]
    with dask_scheduler() as (address, _), dask("worker", address, "--nthreads", 4, cwd=tmp_path) as worker:
        with closing(Cluster(study.document, address)) as executor:
            list(executor.evaluate(jobs[:1]))
            began = time.monotonic()
            list(executor.evaluate(jobs))
            assert time.monotonic() - began > 20 * 0.05
        worker.terminate()


def test_without_a_worker_it_prints_how_to_start_one_and_continues_when_it_joins(start, dask, dask_scheduler, tmp_path):
    with dask_scheduler() as (address, _), start(*STUDY, "--scheduler", address, "--json", cwd=tmp_path) as process:
        assert process.stderr is not None
        line = process.stderr.readline()
        assert line == f"{address} has no worker; waiting for one: dask worker {address} --nthreads 1\n"
        assert not (tmp_path / "run").exists()
        with dask(*line.split()[-5:][1:], cwd=tmp_path) as worker:
            _, err = process.communicate(timeout=600)
            worker.terminate()
    assert process.returncode == 0, err
    assert "Traceback" not in err


def test_workers_that_stop_at_their_limit_of_memory_are_said(start, dask, dask_scheduler, tmp_path):
    small = ("--nthreads", 1, "--no-nanny", "--memory-limit", "50MB")
    with dask_scheduler() as (address, _), dask("worker", address, *small, cwd=tmp_path) as worker:
        with start(*STUDY, "--scheduler", address, cwd=tmp_path) as process:
            assert process.stderr.readline().startswith(f"{address} has only workers near their limit of memory")
            process.kill()
        worker.terminate()


def test_a_lost_scheduler_costs_nothing_and_the_command_to_resume_is_printed(
    start, dask, dask_scheduler, run, rows, tmp_path
):
    with (
        dask_scheduler() as (address, scheduler),
        dask("worker", address, "--nthreads", 1, cwd=tmp_path) as worker,
        start(*STUDY, "--set", "simulator.pause=0.05", "--scheduler", address, cwd=tmp_path) as process,
    ):
        wait_until(lambda: process.poll() is not None or count_evaluations(tmp_path / "run") >= 20)
        scheduler.kill()
        _, err = process.communicate(timeout=600)
        worker.kill()
    assert process.returncode == 1
    # A library may say more of the connection on a busy machine.
    [line] = [line for line in err.splitlines() if line.startswith("error: ")]
    assert "Traceback" not in err
    assert line.startswith(f"error: {address}: the connection to the scheduler is lost; stopped after ")
    assert line.endswith(" of 60 evaluations; resume with: driftform resume run")
    assert int(line.split("stopped after ")[1].split()[0]) >= 20

    assert run("resume", "run", "--workers", 1, cwd=tmp_path).returncode == 0
    interrupted = rows(tmp_path / "run")
    (tmp_path / "run").rename(tmp_path / "interrupted")
    assert run(*STUDY, "--workers", 1, cwd=tmp_path).returncode == 0
    assert rows(tmp_path / "run") == interrupted


def test_a_scheduler_with_tls_is_joined_as_the_page_says(study, dask, tmp_path, monkeypatch):
    import dask as dask_package

    if shutil.which("openssl") is None:
        pytest.skip("openssl is not installed")
    page = (Path(__file__).parents[2] / "docs" / "running.md").read_text(encoding="utf-8")
    command = next(line for line in page.splitlines() if line.startswith("openssl req "))
    subprocess.run(command.split(), cwd=tmp_path, check=True, capture_output=True)
    flags = ("--tls-ca-file", "cert.pem", "--tls-cert", "cert.pem", "--tls-key", "key.pem")
    assert f"dask scheduler --protocol tls {' '.join(flags)}" in page
    options = ("--protocol", "tls", "--host", "127.0.0.1", "--port", 0, "--no-dashboard")
    file = tmp_path / "scheduler.json"
    with dask("scheduler", *flags, *options, "--scheduler-file", file, cwd=tmp_path) as scheduler:
        while not file.exists():
            assert scheduler.poll() is None, "the scheduler ended"
            time.sleep(0.05)
        address = json.loads(file.read_text())["address"]
        with dask("worker", address, *flags, "--nthreads", 1, cwd=tmp_path) as worker:
            monkeypatch.setattr(cluster, "CONNECT_TIMEOUT_S", 2.0)
            with pytest.raises(InputError, match="no Dask scheduler answers there"):
                Cluster(study.document, address)
            monkeypatch.setattr(cluster, "CONNECT_TIMEOUT_S", 10.0)
            settings = {
                "distributed.comm.tls.ca-file": str(tmp_path / "cert.pem"),
                "distributed.comm.tls.client.cert": str(tmp_path / "cert.pem"),
                "distributed.comm.tls.client.key": str(tmp_path / "key.pem"),
            }
            with dask_package.config.set(settings), closing(Cluster(study.document, address)) as executor:
                [[(_, evaluation)]] = list(executor.evaluate([job(study)]))
            assert evaluation.failure is None
            worker.terminate()
        scheduler.terminate()


def test_other_versions_on_a_worker_are_refused(study, dask_cluster, monkeypatch):
    other = find_versions(study.document) | {"driftform-fake": "2.0"}
    monkeypatch.setattr(cluster, "find_versions", lambda _: other)
    with (
        closing(Cluster(study.document, dask_cluster)) as executor,
        pytest.raises(InputError, match=r"^worker tcp://\S+ has driftform-fake 1\.0, this run has 2\.0: install"),
    ):
        list(executor.evaluate([job(study)]))


def test_versions_that_affect_an_outcome_are_compared(study):
    found = find_versions(study.document)
    assert {"driftform", "driftform-lsystem", "driftform-frusta", "driftform-fake", "numpy"} <= found.keys()
    assert "driftform-exudyn" not in found


def test_workers_that_lack_a_plugin_of_the_study_report_it(study, dask_cluster):
    document = study.document | {"simulator": {"use": "unheard-of"}}
    with (
        closing(Cluster(document, dask_cluster)) as executor,
        pytest.raises(InputError, match=r"^worker tcp://\S+: no simulator is named 'unheard-of'"),
    ):
        list(executor.evaluate([job(study)]))


def test_workers_that_cannot_import_the_task_report_it(study, dask_cluster, monkeypatch):
    monkeypatch.setattr(cluster, "_call", work_that_breaks)
    with (
        closing(Cluster(study.document, dask_cluster)) as executor,
        pytest.raises(WorkFailedError, match=r"its workers cannot evaluate \(No module .*\); install the same"),
    ):
        list(executor.evaluate([job(study)]))


def work_that_breaks(*_):
    """A task of this module, which no worker can import."""


@pytest.mark.peers
@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("tcp://127.0.0.1:9", "no Dask scheduler answers there;"),
        ("nowhere://x:1", "no Dask scheduler answers there ("),
        ("tcp://no-such-host.invalid:8786", "no Dask scheduler answers there ("),
        ("", "no Dask scheduler answers there ("),
    ],
)
def test_an_address_without_a_scheduler_is_refused(refused, address, message, monkeypatch):
    monkeypatch.setattr(cluster, "CONNECT_TIMEOUT_S", 1.0)
    line = refused("evolve", "--out", "run", "--scheduler", address)
    assert line.startswith(f"error: --scheduler {address}: {message}")
    assert "'dask scheduler'" in line


def test_a_number_of_workers_and_a_scheduler_exclude_each_other(refused):
    line = refused("evolve", "--out", "run", "--workers", 2, "--scheduler", "tcp://x:1")
    assert line.startswith("error: --workers 2: a cluster has the workers that joined it")


def test_without_the_extra_it_prints_how_to_install_it(refused, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    line = refused("evolve", "--scheduler", "tcp://x:1", "--out", "run")
    assert line.startswith("error: --scheduler needs Dask (")
    assert line.endswith("): uv sync --extra dask, or pip install 'driftform[dask]'")
