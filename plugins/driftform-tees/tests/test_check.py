"""The errors of a solved flow: small ones are stated, and a flow that is wrong is refused."""

import math
import re
from dataclasses import replace

import pytest

from driftform.errors import WorkFailedError
from driftform.water.parts.tee_store import JUNCTIONS, PACKAGED, _read, file_name
from driftform.water.parts.tee_wall import Junction
from driftform_tees.solve import _end_points, describe_errors

WYES = [Junction(branch, math.radians(angle), 0.2 * branch) for branch, angle in ((0.7, 45), (0.7, 60), (1.0, 45))]


@pytest.mark.parametrize("junction", [*JUNCTIONS, *WYES])
def test_errors_of_flows_that_come_with_driftform_are_at_most_as_large_as_it_says(junction):
    line = describe_errors(junction, _read(PACKAGED / file_name(junction)), _end_points(junction.array()))
    flux, divergence, most_flux, most = map(float, re.findall(r"\d[\d.e-]*", line))
    assert flux <= most_flux and divergence <= most


def test_a_flow_with_too_much_water_or_of_another_shape_is_refused():
    tee = JUNCTIONS[1]
    found = _read(PACKAGED / file_name(tee))
    for junction, flow in ((tee, replace(found, branch=1.1 * found.branch)), (replace(tee, angle=math.pi / 3), found)):
        with pytest.raises(WorkFailedError, match="too large to fly by; choose a larger fillet"):
            describe_errors(junction, flow, _end_points(junction.array()))
