"""A run with its page."""

import pytest

from driftform.runs.directory import DATABASE
from driftform.runs.run import StoredRun
from driftform.runs.store import Store
from driftform.search.local import InProcess
from driftform.search.loop import run_search
from driftform.search.report.page import write_report
from driftform.study import load_study


@pytest.fixture(scope="session")
def run_with_page(tmp_path_factory):
    """A run of twenty flights for ten targets, with its page."""
    directory = tmp_path_factory.mktemp("runs") / "run"
    directory.mkdir()
    study = load_study("paper", use={"simulator": "native", "strategy": "random"}, run={"seed": 4, "evaluations": 20})
    with Store.create(directory / DATABASE, dict(study.document)) as store:
        run_search(study, store, InProcess(study.make_pipeline()))
    write_report(StoredRun.open(directory), None)
    return directory
