"""Published experiments: what was measured, what driftform finds, and the page that shows both.

Each other file of this folder is an experiment with a section of docs/experiments.md: ``measure()`` returns rows of what is
compared, what was measured, and what is found.
"""

import importlib.util
import re
from pathlib import Path

import pytest
from pages import split_page

from driftform.util.validity import RANGES

FOLDER = Path(__file__).parent
NAMES = sorted(path.stem for path in FOLDER.glob("*.py") if not path.stem.startswith(("test_", "conftest")))


def load(name):
    spec = importlib.util.spec_from_file_location(f"experiment_{name}", FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def experiments():
    """The experiments by name, and the rows that they measure."""
    modules = {name: load(name) for name in NAMES}
    return {name: (module, list(module.measure())) for name, module in modules.items()}


@pytest.fixture(scope="module")
def found(experiments):
    """What is found, by what is compared."""
    return {what: value for _, rows in experiments.values() for what, _, value in rows}


def number(value):
    return value if isinstance(value, str) else f"{value:.3g}"


def difference(measured, value):
    if isinstance(measured, str) or isinstance(value, str) or not measured:
        return ""
    return f"{100 * (value / measured - 1):+.0f} %"


def test_the_page_shows_what_each_experiment_finds_and_says_whether_it_is_met(experiments, published):
    for name, (_, rows) in experiments.items():
        title = name.replace("_", " ")
        _, text, _, _ = split_page(title)
        assert re.search(r"^(Not met|Met)[:,] ", text.rpartition("\n## ")[2], re.MULTILINE)
        lines = ["| quantity | measured | found | off by |", "|---|---|---|---|"]
        published(title, lines + [f"| {q} | {number(m)} | {number(v)} | {difference(m, v)} |" for q, m, v in rows])


@pytest.mark.parametrize(
    ("name", "measured", "within"),
    [("Y_v'", -5.948, 0.15), ("N_v'", -12.795, 0.15), ("Y_r'", 1.811, 0.15), ("N_r'", -1.597, 0.40)],
)
def test_a_submarine_hull_has_the_measured_derivatives(found, name, measured, within):
    assert found[f"{name}, thousandths"] == pytest.approx(measured, rel=within)


def test_spheres_settle_at_most_an_eighth_too_fast(found):
    for oil, measured in enumerate((0.0363, 0.0571, 0.0869, 0.1226), 1):
        assert 0.95 < found[f"ten Cate, oil {oil}: greatest speed, m/s"] / measured < 1.13
    assert found["Rostami: depth, off the three terms by, %"] < 1


def test_cylinders_fall_broadside_as_fast_as_measured(found):
    for aspect, measured in ((5, 0.74), (10, 0.82)):
        (value,) = (v for what, v in found.items() if what.startswith(f"C_d broadside, {aspect} "))
        assert value == pytest.approx(measured, rel=0.10)


def test_end_heavy_cylinders_fall_upright_if_short_and_drift_at_a_constant_tilt_if_long(experiments):
    falling = experiments["falling_cylinders"][0]
    least, most, drift = falling.end_heavy(1)
    assert least < 1 and most < 20 and drift < 0.01
    least, most, drift = falling.end_heavy(4)
    assert 20 < least == pytest.approx(most, abs=0.1) and most < 85 and drift > 0.1


def test_neutral_bodies_are_as_fast_as_measured_and_as_the_middle_of_the_flow_allows(found):
    # The logarithmic law on the axis: 1 + 1.5 u* / (kappa U), with Prandtl's friction at Re = 31 750.
    ahead = 1 + 1.5 * (0.0234 / 8) ** 0.5 / 0.4
    for shape in ("sphere", "cylinder"):
        speeds = [v for what, v in found.items() if what.startswith(f"{shape}, d/D ")]
        assert len(speeds) >= 5 and all(1.05 < speed < ahead for speed in speeds)
        assert speeds == sorted(speeds, reverse=True), "the smaller the faster"
    for ratio in (0.31, 0.69):
        assert 1.05 < found[f"sphere in gusts, d/D {ratio}"] < ahead


def test_spheres_bounce_in_oil_as_high_and_as_late_as_measured(experiments):
    _, rows = experiments["bounces"]
    assert len(rows) == 14
    for what, measured, value in rows:
        if "with history" not in what:
            heights, times = (0.25, 0.18) if "St 152" in what else (0.5, 0.25)
            assert value == pytest.approx(measured, rel=heights if "height" in what else times), what


def test_the_history_force_is_what_the_first_bounces_lack(experiments):
    _, rows = experiments["bounces"]
    remembered = {what.removeprefix("with history, "): row for what, *row in rows if "with history" in what}
    without = {what: value for what, _, value in rows}
    assert len(remembered) == 3
    for what, (measured, value) in remembered.items():
        assert value == pytest.approx(measured, rel=0.06), what
        assert abs(value - measured) < abs(without[what] - measured) / 2, what


def test_heavy_spheres_roll_along_a_tight_pipe_about_as_fast_as_the_water(experiments):
    rows = {what: value for what, _, value in experiments["spheres_in_pipes"][1]}
    assert all(v == pytest.approx(1, abs=0.05) for what, v in rows.items() if "rolling" in what)
    for ratio, least in ((0.5, 1.0), (0.69, 1.035)):
        assert all(least < v < 1.08 for what, v in rows.items() if "water" in what and f"d/D {ratio}" in what)


def test_heavy_cylinders_are_not_faster_than_measured_but_peak_lower(experiments):
    module, rows = experiments["cylinders_in_pipes"]
    found = {what: value for what, _, value in rows}
    assert 1.05 < max(value for what, value in found.items() if "balance" not in what) < 1.15
    # Why: the gap around a long cylinder, which the model lacks, has Ellis' neutral ones within his bounds.
    for ratio in (0.39, 0.6, 0.8, 0.89):
        assert 1.05 < module.balance_gap(ratio) < 1.5
        # Without friction drag alone acts, and vanishes where the body is as fast as the water around it.
        assert found[f"d/D {ratio}, no friction"] == pytest.approx(module.average_profile(ratio), abs=0.015)
        assert not RANGES["a body in a bore"][0].contains(ratio)
    assert module.balance_gap(1.0) == pytest.approx(1.0) and module.balance_gap(0.8) > 1.15


def test_spheres_roll_along_a_bed_within_the_scatter_of_the_water_at_their_top(experiments):
    rows = {what: value for what, _, value in experiments["rolling_spheres"][1]}
    at_top = {what.rpartition(", ")[0]: v for what, v in rows.items() if what.endswith("at its top")}
    assert len(at_top) == 5 and all(0.7 < value < 1.3 for value in at_top.values())
    for what, value in at_top.items():
        assert rows[f"{what}, level"] < value, "the slope drives a sphere as it drives the water"
        assert rows[f"{what}, level"] < rows[f"{what}, level, no friction"] < 1, "the water's couple holds it back"
    # "Up to approximately 20", with their scatter of 30 %.
    assert max(value for what, value in rows.items() if "u*" in what) < 26


def test_a_sphere_lifts_off_a_floor_if_it_is_light_and_not_if_it_is_dense(experiments):
    rows = {what: value for what, _, value in experiments["lifting_spheres"][1]}
    for units in (58, 122):
        light, middle, dense = (v for what, v in rows.items() if f"d+ {units}:" in what)
        assert light > 0.5 and dense < 0.1
        assert light > middle >= dense
