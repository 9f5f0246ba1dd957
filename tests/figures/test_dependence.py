"""The bars of what a miss depends on."""

import pytest

from driftform.figures.dependence import dependence_svg
from driftform.runs.misses import REST, Effect

EFFECTS = [
    Effect("drag", 0.2, ""),
    Effect("current", 0.05, ""),
    Effect("water density", 0.0, ""),
    Effect(REST, 0.1, ""),
]


def test_each_bar_is_as_long_as_its_effect(read):
    picture = read(dependence_svg(EFFECTS, "TP1"))
    drag, current, density, rest = (float(bar.get("width")) for bar in picture.all("effect"))
    assert current == pytest.approx(drag / 4, rel=0.01)
    assert rest == pytest.approx(drag / 2, rel=0.01)
    assert 0 < density <= 1


def test_each_bar_has_its_name_and_its_length():
    text = dependence_svg(EFFECTS, "TP1")
    assert "0.0 mm" in dependence_svg([Effect("drag", 0.0, "")], "TP1"), "all are zero"
    for words in ("TP1", "drag", "200 mm", "50 mm", "0.0 mm", REST, "100 mm"):
        assert words in text
