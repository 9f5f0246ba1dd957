"""What strategies find is kept by their run: the same after an interruption, and drawn in the report."""

from contextlib import suppress

import pytest

from driftform.errors import InputError
from driftform.runs.found import FOUND, read_found
from driftform.runs.run import StoredRun
from driftform.search.advance import Observer, search_run
from driftform.search.local import InProcess
from driftform.search.report.contents import collect_contents
from driftform.study import load_study

ARCHIVE = [
    *("strategy.use=ribs", "strategy.emitter=cma-me", "strategy.archive=grid", "strategy.cells=36"),
    *("strategy.batch=10", "strategy.emitters=2", "strategy.measures={mass=[0.05, 0.2], length=[0.02, 0.25]}"),
]

FRONT = ["strategy.use=pymoo", "strategy.objectives=['fitness', 'length']", "strategy.population=10"]


class Stop(Observer):
    def record(self, record):
        if record.index == 37:
            raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("settings", "name", "axes"), [(ARCHIVE, "archive", ["mass", "length"]), (FRONT, "front", ["fitness", "length"])]
)
def test_a_run_that_was_stopped_resumes_to_the_same_results_and_draws_them(tmp_path, settings, name, axes):
    study = load_study(
        "paper",
        settings,
        use={"simulator": "native", "grammar": "bspline"},
        targets=["TP5"],
        run={"seed": 3, "evaluations": 60},
    )
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    for path, observer in ((whole, None), (cut, Stop())):
        with suppress(KeyboardInterrupt), StoredRun.create(path, study) as run:
            search_run(run, InProcess(study.make_pipeline()), observer)
    assert not (cut / FOUND).exists()
    with StoredRun.resume(cut) as run:
        search_run(run, InProcess(study.make_pipeline()))
    for suffix in ("json", "csv"):
        assert (cut / FOUND / f"{name}.{suffix}").read_bytes() == (whole / FOUND / f"{name}.{suffix}").read_bytes()

    [found] = read_found(whole / FOUND).values()
    assert list(found.axes) == axes
    with StoredRun.open(whole).read() as store:
        rows = list(store.read_records(study.scenario.target_names))
    kept = [found.columns[key].tolist() for key in ("evaluation", "fitness", "length")]
    for index, fitness, length in zip(*kept, strict=True):
        evaluation = rows[int(index)].evaluation
        assert (fitness, length) == (evaluation.fitness[0], evaluation.measures["length"])
    figures = collect_contents(StoredRun.open(whole)).figures
    assert f"{name.capitalize()} of {study.document['strategy']['use']}" in figures

    (whole / FOUND / f"{name}.json").write_text('{"meaning": "x", "columns": {"a": [1], "b": []}}')
    with pytest.raises(InputError, match=r"is damaged: the columns of a result are finite numbers, as many in each; "):
        read_found(whole / FOUND)
