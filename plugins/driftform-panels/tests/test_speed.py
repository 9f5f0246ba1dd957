"""How long a body takes, and how exact it is. By hand: ``pytest -m slow -s plugins/driftform-panels/tests/test_speed.py``."""

import time

import numpy as np
import pytest
from solids import reciprocity

from driftform.water import Fluid
from driftform_panels.solve import PanelMethod, PanelOptions, solve
from driftform_striptheory.coefficients import StripTheory, StripTheoryOptions

pytestmark = pytest.mark.slow


def test_a_random_body_takes_two_milliseconds_by_panels_and_a_fifth_of_one_by_strips(random_bodies):
    """CPU time of the process, of all its threads, which does not count what else the machine does."""
    bodies, fluid = random_bodies(200, 5), Fluid()
    assert all(len(body.joints) > 39 for body in bodies)
    models = {"panels": PanelMethod(PanelOptions()), "strip theory": StripTheory(StripTheoryOptions())}
    best = {}
    for name, model in models.items():
        model.coefficients(bodies[0], fluid)
        times = np.empty((9, len(bodies)))
        for repeat in times:
            for index, body in enumerate(bodies):
                start = time.process_time()
                model.coefficients(body, fluid)
                repeat[index] = 1e3 * (time.process_time() - start)
        best[name] = times.min(axis=0)
    unknowns = [solve(body.outer).unknowns for body in bodies]
    for name, ms in best.items():
        print(f"{name}: {np.median(ms):.3g} ms in the median, {np.quantile(ms, 0.9):.3g} ms for 9 of 10")
    print(f"{np.median(unknowns):.0f} unknowns of the panels in the median, {max(unknowns)} at most")
    assert np.median(best["panels"]) < 2.0
    assert np.median(best["strip theory"]) < 0.2


def test_the_default_panels_are_as_accurate_as_the_model_claims(random_bodies):
    fine = PanelOptions(panels=100, corner=0.02)
    errors, ratios, unequal = [], [], []
    for body in random_bodies(200, 11):
        a, b = solve(body.outer), solve(body.outer, fine)
        size = np.sqrt(b.sway * b.yaw)
        coupling = (a.sway_of_yaw + a.yaw_of_sway - b.sway_of_yaw - b.yaw_of_sway) / 2
        errors.append([a.surge / b.surge - 1, a.sway / b.sway - 1, a.yaw / b.yaw - 1, coupling / size])
        ratios.append(b.unknowns / a.unknowns)
        unequal.append(reciprocity(a))
    percent = 100 * np.abs(errors)
    print(f"\nlargest change of A11, A22, A66, A26: {percent.max(axis=0).round(4)} %, 95 %:", end=" ")
    print(f"{np.quantile(percent, 0.95, axis=0).round(4)} %, with {np.median(ratios):.1f} times the unknowns;")
    print(f"largest error of reciprocity {max(unequal):.1e}")
    assert (percent.max(axis=0) < [0.1, 0.03, 0.03, 0.03]).all()
    assert max(unequal) < 1e-4
