import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.figures import svg
from driftform.figures.layout import (
    MINUS,
    Box,
    fit_title,
    floor_to_nice_number,
    format_signed,
    place_labels,
    shorten,
    text_width,
    tick_values,
)


def test_text_is_escaped_and_comes_back_as_it_was(read):
    root = svg.start_document(100, 50, "a < b & c", 'd "e" > f')
    svg.add(root, "text", "x < y & z", x=1, y=2, font_size=12)
    picture = read(svg.render(root))
    assert picture.texts == ["x < y & z"]
    assert [e.text for e in picture.root[:2]] == ["a < b & c", 'd "e" > f']


def test_characters_that_xml_cannot_hold_are_replaced(read):
    root = svg.start_document(100, 50, "bell \x07 null \x00 half a pair \ud800", "")
    assert read(svg.render(root)).root[0].text == "bell \ufffd null \ufffd half a pair \ufffd"


@pytest.mark.parametrize(
    ("value", "text"), [(1.0, "1"), (-0.001, "0"), (2.506, "2.51"), (-3.10, "-3.1"), (100.0, "100")]
)
def test_numbers_are_short(value, text):
    assert svg.format_number(value) == text


def test_a_size_in_millimetres_prints_to_scale():
    root = svg.start_document(96, 192, "", "", unit="mm")
    assert (root.get("width"), root.get("height"), root.get("viewBox")) == ("25.4mm", "50.8mm", "0 0 96 192")


def test_shortened_text_fits_and_says_that_it_was_cut():
    short = shorten("addB-tiltn-1-M-moveB" * 20, 12, 200)
    assert short.endswith("…")
    assert text_width(short, 12) <= 200
    assert shorten("short", 12, 200) == "short"


@settings(deadline=None)
@given(st.text(st.characters(codec="utf-8"), max_size=300), st.floats(12, 20), st.floats(200, 900))
def test_a_title_fits_on_two_lines_and_is_never_cut_within_a_word_that_fits(title, size, width):
    smaller, lines = fit_title(title, size, width)
    assert 0.6 * size - 1 < smaller <= size and 1 <= len(lines) <= 2
    assert all(text_width(line, smaller, bold=True) <= width for line in lines)
    assert "".join(title.split()).startswith("".join(lines).replace(" ", ""))
    assert "…" in title or "…" not in "".join(lines)


def test_a_title_of_a_scenario_is_whole():
    title = "Ten targets in 9 m of a water main of 2 m, in water and with walls as they are"
    for words in (title, f"{title}: {title}"):
        assert " ".join(fit_title(words, 20, 856)[1]) == words


def overlap_area(one, other):
    """The area that two boxes share, px2."""
    w = min(one.right, other.right) - max(one.left, other.left)
    h = min(one.bottom, other.bottom) - max(one.top, other.top)
    return max(w, 0.0) * max(h, 0.0)


def test_labels_of_neighbours_keep_off_each_other_and_stay_on_the_page():
    rng = np.random.default_rng(1)
    anchors = np.vstack([[[50, 50], [58, 50], [50, 58], [398, 5], [2, 198]], rng.uniform((0, 0), (400, 200), (6, 2))])
    page = Box(0, 0, 400, 200)
    boxes = place_labels(anchors, [40] * len(anchors), 14, np.zeros((0, 2)), page)
    for i, box in enumerate(boxes):
        assert overlap_area(box, page) == pytest.approx(40 * 14)
        assert all(overlap_area(box, other) == 0 for other in boxes[:i])


@pytest.mark.parametrize(("value", "nice"), [(0.99, 0.5), (1.0, 1.0), (4.9, 2.0), (130.0, 100.0), (0.05, 0.05)])
def test_nice_steps_are_1_2_5(value, nice):
    assert floor_to_nice_number(value) == pytest.approx(nice)


def test_ticks_include_both_ends():
    assert tick_values(-0.4, 0.4, 0.2) == pytest.approx([-0.4, -0.2, 0, 0.2, 0.4])
    assert not np.signbit(tick_values(-1e-9, 100.0, 20.0)).any()


def test_zero_has_no_sign():
    assert (format_signed(-0.01, 1), format_signed(-2.34, 1)) == ("0.0", MINUS + "2.3")
