"""How long a body takes. Run by hand: ``pytest -m slow -s plugins/driftform-panels/tests/test_speed.py``."""

import time

import numpy as np
import pytest

from driftform.scenario import Fluid
from driftform_panels.coefficients import PanelMethod
from driftform_panels.solve import PanelOptions, solve

pytestmark = pytest.mark.slow


def test_a_random_body_takes_two_milliseconds(random_bodies):
    model, fluid = PanelMethod(PanelOptions()), Fluid()
    bodies = random_bodies(200, 5)
    model.coefficients(bodies[0], fluid)
    times = np.empty((9, len(bodies)))
    for repeat in times:
        for index, body in enumerate(bodies):
            start = time.perf_counter()
            model.coefficients(body, fluid)
            repeat[index] = 1e3 * (time.perf_counter() - start)
    once, best = np.median(times, axis=0), times.min(axis=0)
    unknowns = [solve(body.outer).unknowns for body in bodies]
    print(
        f"\nms for each of {len(bodies)} bodies: median {np.median(once):.2f}, 90 % {np.quantile(once, 0.9):.2f};"
    )
    print(f"the best of nine for each: median {np.median(best):.2f}, 90 % {np.quantile(best, 0.9):.2f};")
    print(f"unknowns: median {np.median(unknowns):.0f}, most {max(unknowns)}")
    assert np.median(best) < 2.0


def test_the_default_panels_are_as_accurate_as_the_model_claims(random_bodies):
    fine = PanelOptions(panels=100, corner=0.02)
    errors, ratios, reciprocity = [], [], []
    for body in random_bodies(200, 11):
        a, b = solve(body.outer), solve(body.outer, fine)
        size = np.sqrt(b.sway * b.yaw)
        coupling = (a.sway_of_yaw + a.yaw_of_sway - b.sway_of_yaw - b.yaw_of_sway) / 2
        errors.append([a.surge / b.surge - 1, a.sway / b.sway - 1, a.yaw / b.yaw - 1, coupling / size])
        ratios.append(b.unknowns / a.unknowns)
        reciprocity.append(a.reciprocity)
    percent = 100 * np.abs(errors)
    print(f"\nlargest change of A11, A22, A66, A26: {percent.max(axis=0).round(4)} %, 95 %:", end=" ")
    print(
        f"{np.quantile(percent, 0.95, axis=0).round(4)} %, with {np.median(ratios):.1f} times the unknowns;"
    )
    print(f"largest error of reciprocity {max(reciprocity):.1e}")
    assert (percent.max(axis=0) < [0.1, 0.03, 0.03, 0.03]).all()
    assert max(reciprocity) < 1e-4
