"""How long the files of an agent take, beside OpenSCAD on the same body.

Run by hand: ``pytest -m slow -s tests/benchmarks``. With ``UPDATE_DOCS=1`` the table goes into docs/validation.md.
"""

import resource
import shutil
import subprocess
import time
from collections.abc import Callable

import numpy as np
import pytest

from driftform.interfaces import Specimen
from driftform.study import load_study
from driftform_frusta.exporters.scad import ScadExporter
from driftform_frusta.exporters.stl import StlExporter
from driftform_frusta.exporters.svg import SvgExporter
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.hull import hull
from driftform_frusta.mesh import mesh_of
from driftform_frusta.parts import PartOptions, parts_of
from driftform_frusta.solid import to_solid

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def specimens():
    pipeline, rng = load_study(run={"seed": 0}).pipeline(), np.random.default_rng(0)
    agents = [pipeline.agent(pipeline.grammar.random(rng)) for _ in range(20)]
    return [Specimen(f"agent-{i}", agent, pipeline.scenario, {"n": i}) for i, agent in enumerate(agents)]


def openscad_milliseconds(source, path):
    """CPU time of one rendering."""

    def spent():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return 1e3 * (used.ru_utime + used.ru_stime)

    start = spent()
    subprocess.run(["openscad", "-o", str(path), str(source)], capture_output=True, check=True, timeout=900)
    return spent() - start


def milliseconds(function: Callable[[Specimen], object], specimens: list[Specimen]) -> list[float]:
    """CPU time for each of them, the best of five."""
    times = []
    for specimen in specimens:
        calls = []
        for _ in range(5):
            start = time.process_time()
            function(specimen)
            calls.append(1e3 * (time.process_time() - start))
        times.append(min(calls))
    return times


def test_files_for_printers(publish, specimens, tmp_path):
    def written(exporter, **options):
        made = exporter(exporter.Options(**options))
        return lambda specimen: made.write(specimen, tmp_path / f"agent{made.suffix}")

    def mesh(specimen):
        return to_solid(hull(specimen.agent.body), 96)

    def checked(specimen):
        return mesh_of(parts_of(specimen.agent.body, PartOptions(segments=96))[0].on_bed())

    stages = {
        "mesh of the hull, 96 segments": mesh,
        "the same, all checks passed, in single precision": checked,
        "STL of the sealed hull": written(StlExporter),
        "3MF of the sealed hull, with picture and attachments": written(ThreeMfExporter),
        "3MF of the kit, with picture and attachments": written(ThreeMfExporter, kit=True),
        "drawing (SVG)": written(SvgExporter),
    }
    for function in stages.values():
        function(specimens[0])
    times = {name: milliseconds(function, specimens) for name, function in stages.items()}
    lines = ["| what | median ms | 90 % ms | OpenSCAD over that |", "|---|---|---|---|"]
    rendered = {False: None, True: None}
    if shutil.which("openscad"):
        for kit, count in ((False, 5), (True, 2)):
            spent = []
            for specimen in specimens[:count]:
                written(ScadExporter, kit=kit)(specimen)
                spent.append(openscad_milliseconds(tmp_path / "agent.scad", tmp_path / "agent.stl"))
            rendered[kit] = float(np.median(spent))
    for name, found in times.items():
        openscad = None if "SVG" in name else rendered["kit" in name]
        ratio = "" if openscad is None else f"{openscad / np.median(found):.3g}"
        lines.append(f"| {name} | {np.median(found):.3g} | {np.quantile(found, 0.9):.3g} | {ratio} |")
    lines += [
        "",
        f"{len(specimens)} random agents, CPU time, each the best of five; with 64 segments where none are told.",
    ]
    publish("files for printers", lines)
    assert np.median(times["mesh of the hull, 96 segments"]) <= 10
    assert np.median(times["3MF of the kit, with picture and attachments"]) <= 150
