"""Do kits of what searches find fit the bed of a common printer, with a way into their parts for core and ballast?"""

import pytest

from driftform.design.opening import open_agent
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts, settle_ballast

pytestmark = pytest.mark.slow

BED = (0.22, 0.22, 0.25)
"""Width, depth and height, m."""


@pytest.mark.parametrize("scenario", ["pipe-inspection", "paper"])
def test_all_winners_of_a_run_make_kits_for_a_common_bed(scenario, start, tmp_path):
    search = ("evolve", scenario, "--seed", 1, "--evaluations", 500, "--simulator", "native", "--out", "run")
    with start(*search, cwd=tmp_path) as process:
        _, told = process.communicate(timeout=3600)
    assert process.returncode == 0, told
    winners = sorted(path.name for path in (tmp_path / "run" / "best").iterdir())
    assert len(winners) == 10
    for target in winners:
        body = open_agent(f"{tmp_path / 'run'}:{target}").agent.body
        parts = make_parts(body, settle_ballast(body, PartOptions(kit=True, bed=BED)))
        sizes = [part.on_bed().bounds[1] - part.on_bed().bounds[0] for part in parts]
        print(f"{scenario} {target}: {1000 * body.length:.0f} mm in {len(parts)} parts")
        assert len(parts) > 1 and all((size <= [1000 * side for side in BED]).all() for size in sizes)
