"""How long the files of an agent take.

Run by hand: ``pytest -m slow -s tests/benchmarks``.
"""

import time
from collections.abc import Callable

import numpy as np
import pytest

from driftform.interfaces import ExportJob
from driftform.study import load_study
from driftform_frusta.exporters.meshes import StlExporter
from driftform_frusta.exporters.svg import SvgExporter
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.hull import build_hull
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_frusta.solid import make_mesh, to_solid

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def jobs():
    pipeline, rng = load_study(run={"seed": 0}).make_pipeline(), np.random.default_rng(0)
    agents = [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(20)]
    return [ExportJob(f"agent-{i}", agent, pipeline.scenario, {"n": i}) for i, agent in enumerate(agents)]


def milliseconds(function: Callable[[ExportJob], object], jobs: list[ExportJob]) -> list[float]:
    """CPU time for each of them, the best of five."""
    times = []
    for job in jobs:
        calls = []
        for _ in range(5):
            start = time.process_time()
            function(job)
            calls.append(1e3 * (time.process_time() - start))
        times.append(min(calls))
    return times


def test_files_for_printers(jobs, tmp_path):
    def written(exporter, **options):
        made = exporter(exporter.Options(**options))
        return lambda job: made.write(job, tmp_path / f"agent{made.suffix}")

    def mesh(job):
        return to_solid(build_hull(job.agent.body), 96)

    def checked(job):
        return make_mesh(make_parts(job.agent.body, PartOptions(segments=96))[0].on_bed())

    stages = {
        "mesh of the hull, 96 segments": mesh,
        "the same, all checks passed, in single precision": checked,
        "STL of the sealed hull": written(StlExporter),
        "3MF of the sealed hull, with picture and attachments": written(ThreeMfExporter),
        "3MF of the kit, with picture and attachments": written(ThreeMfExporter, kit=True),
        "drawing (SVG)": written(SvgExporter),
    }
    for function in stages.values():
        function(jobs[0])
    times = {name: milliseconds(function, jobs) for name, function in stages.items()}
    lines = ["| what | median ms | 90 % ms |", "|---|---|---|"]
    for name, found in times.items():
        lines.append(f"| {name} | {np.median(found):.3g} | {np.quantile(found, 0.9):.3g} |")
    lines += [
        "",
        f"{len(jobs)} random agents, CPU time, each the best of five; with 64 segments unless stated otherwise.",
    ]
    print("", *lines, sep="\n")
    assert np.median(times["mesh of the hull, 96 segments"]) <= 10
    assert np.median(times["3MF of the kit, with picture and attachments"]) <= 150
