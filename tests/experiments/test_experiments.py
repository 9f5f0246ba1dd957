"""Published experiments: what was measured, what driftform finds, and the page that shows both.

Each other file of this folder is an experiment: its docstring is the page's text, its first line the heading, and
``measure()`` returns rows of what is compared, what was measured, and what is found.
"""

import importlib.util
from pathlib import Path

import pytest

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


def test_the_page_has_every_experiment(experiments, published):
    lines = []
    for module, rows in experiments.values():
        heading, _, text = module.__doc__.strip().partition("\n")
        lines += ["", f"## {heading}", "", text.strip(), ""]
        lines += ["| quantity | measured | found | off by |", "|---|---|---|---|"]
        lines += [f"| {q} | {number(m)} | {number(v)} | {difference(m, v)} |" for q, m, v in rows]
    published("experiments", lines[1:])


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


def test_small_neutral_bodies_are_as_fast_as_the_middle_of_the_flow_allows(found):
    # The logarithmic law on the axis: 1 + 1.5 u* / (kappa U), with Prandtl's friction at Re = 31 750.
    ahead = 1 + 1.5 * (0.0234 / 8) ** 0.5 / 0.4
    speeds = [found[f"{shape}, d/D {ratio}"] for shape in ("sphere", "cylinder") for ratio in (0.1, 0.2, 0.3)]
    assert all(1.05 < speed < ahead for speed in speeds)
    assert speeds[:3] == sorted(speeds[:3], reverse=True), "the smaller the faster"


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


def test_heavy_spheres_roll_along_a_tight_pipe_about_as_fast_as_the_water(found):
    for feet in (2.5, 5.0):
        assert 1.0 < found[f"{feet} ft/s: velocity over that of the water"] < 1.12
        assert found[f"{feet} ft/s: speed of the surface over that of rolling"] == pytest.approx(1, abs=0.05)
