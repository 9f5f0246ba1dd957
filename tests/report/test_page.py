"""The page of a run, opened from disk in a browser without a network."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from accessibility import find_barriers, look
from chromium import measure_pixels

from driftform.runs.run import StoredRun
from driftform.search.report.contents import collect_contents
from driftform.search.report.page import page_html, viewer_data
from driftform.util.rotations import matrix_from_quaternion
from driftform.util.validity import RANGES
from driftform.water.flow import PowerLawFlow


@pytest.fixture
def page(browser, run_with_page):
    """The page, opened anew, 1400 px wide, in light colours."""
    look(browser, 1400, "light")
    browser.get_log("browser")
    browser.get((run_with_page / "report.html").as_uri())
    return browser


def test_the_page_opens_without_a_network_and_without_a_console_message(page):
    page.get_log("performance")
    page.refresh()
    asked = [
        json.loads(entry["message"])["message"]["params"]["request"]["url"]
        for entry in page.get_log("performance")
        if json.loads(entry["message"])["message"]["method"] == "Network.requestWillBeSent"
    ]
    assert asked and all(url.startswith(("file:", "data:")) for url in asked)
    assert page.get_log("browser") == []


@pytest.mark.parametrize("view", ["agent-view", "flight-view"])
def test_something_is_drawn_and_no_more_than_there_is_room_for(page, view):
    share, _ = measure_pixels(page, view)
    assert 0.005 < share < 0.6


def test_scrubbing_moves_the_agent_by_the_keyboard_too(page):
    from selenium.webdriver import Keys

    before = measure_pixels(page, "flight-view")
    shown = page.find_element("id", "moment").text
    page.execute_script(
        "const t = document.getElementById('time'); t.value = 900; t.dispatchEvent(new Event('input'));"
    )
    assert measure_pixels(page, "flight-view") != before
    assert page.find_element("id", "moment").text != shown

    slider = page.find_element("id", "time")
    shown = page.find_element("id", "moment").text
    slider.send_keys(Keys.ARROW_RIGHT * 30)
    assert page.find_element("id", "moment").text != shown
    assert slider.get_attribute("aria-valuetext") == page.find_element("id", "moment").text


def test_the_closest_approach_on_the_page_is_that_of_the_run(page, run_with_page):
    contents = collect_contents(StoredRun.open(run_with_page))
    for number, group in enumerate(contents.agents[:3]):
        entry = group[0]
        page.find_elements("css selector", "[data-agent]")[number].click()
        found = re.search(r"([\d.]+) (mm|m) from ([^\s,]+)", page.find_element("id", "moment").text)
        distance = float(found[1]) / (1000 if found[2] == "mm" else 1)
        assert found[3] == entry.target
        # The slider has a thousand steps: 9 mm of the way.
        assert distance == pytest.approx(entry.distance, abs=0.01)


def test_cutting_open_turning_and_choosing_change_the_picture(page):
    from selenium.webdriver import Keys

    seen = [measure_pixels(page, "agent-view")]
    page.find_element("id", "cut").click()
    seen.append(measure_pixels(page, "agent-view"))
    page.find_element("id", "agent-view").send_keys(Keys.ARROW_LEFT)
    seen.append(measure_pixels(page, "agent-view"))
    page.find_element("id", "agent-in").click()
    seen.append(measure_pixels(page, "agent-view"))
    page.find_elements("css selector", "[data-agent]")[2].click()
    seen.append(measure_pixels(page, "agent-view"))
    assert len({digest for _, digest in seen}) == len(seen)
    page.find_element("id", "agent-home").click()
    page.find_elements("css selector", "[data-agent]")[0].click()
    page.find_element("id", "cut").click()
    assert measure_pixels(page, "agent-view") == seen[0]
    assert page.get_log("browser") == []


@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_overflows_on_a_phone_or_on_a_desk_and_axe_finds_no_barrier(page, width, scheme):
    look(page, width, scheme)
    page.refresh()
    wide = page.execute_script("return [document.documentElement.scrollWidth, window.innerWidth]")
    assert wide[0] <= wide[1] == width
    assert page.get_log("browser") == []
    page.execute_script("document.querySelectorAll('details').forEach((e) => { e.open = true; })")
    assert find_barriers(page) == []


@pytest.mark.parametrize("width", [390, 1280])
def test_the_tables_are_read_without_scrolling_and_no_letter_of_a_figure_is_tiny(page, width):
    look(page, width, "light")
    page.refresh()
    assert page.execute_script(
        "return [...document.querySelectorAll('.agents td, .agents th')].every((e) => {"
        "const card = e.closest('.card'), { right } = e.getBoundingClientRect();"
        "return card.scrollWidth <= card.clientWidth && right <= card.getBoundingClientRect().right; })"
    )
    sizes = page.execute_script(
        "return [...document.querySelectorAll('figure:not([hidden]) text')].map((e) => "
        "parseFloat(e.getAttribute('font-size')) * e.getScreenCTM().a)"
    )
    assert len(sizes) > 50
    assert min(sizes) >= 8


def test_targets_that_share_an_agent_share_its_row_its_button_and_its_section(page, run_with_page):
    groups = collect_contents(StoredRun.open(run_with_page)).agents
    names = [[entry.target for entry in group] for group in groups]
    assert max(map(len, names)) > 1
    rows = page.find_elements("css selector", "[aria-label='Table of the best agents'] tbody tr")
    assert [row.find_element("css selector", "th").text.split("\n") for row in rows] == names
    buttons = page.find_elements("css selector", "[data-agent]")
    assert [button.text for button in buttons] == [", ".join(group) for group in names]
    for number, button in enumerate(buttons):
        button.click()
        [shown] = [f for f in page.find_elements("css selector", "[data-section]") if f.is_displayed()]
        assert shown.get_attribute("data-section") == str(number)
        assert ", ".join(names[number]) in shown.get_attribute("textContent")


def names_in_view(page):
    """Names of the targets that are seen, with their places on the canvas, px."""
    return page.execute_script(
        "const box = document.getElementById('flight-view').getBoundingClientRect();"
        "return Object.fromEntries([...document.querySelectorAll('#names span')].filter((e) => !e.hidden)"
        ".map((e) => [e.textContent, e.getBoundingClientRect()])"
        ".map(([name, r]) => [name, [r.left - box.left, r.top - box.top]])"
        ".filter(([, [x, y]]) => x >= 0 && y >= 0 && x < box.width && y < box.height))"
    )


def test_targets_are_named_and_the_view_follows_the_agent(page, run_with_page):
    scenario = StoredRun.open(run_with_page).study.scenario
    page.find_elements("css selector", "[data-agent]")[0].click()

    def scrub(value):
        page.execute_script(
            "const t = document.getElementById('time'); t.value = arguments[0]; t.dispatchEvent(new Event('input'));",
            value,
        )
        return names_in_view(page)

    early, late = scrub(50), scrub(950)
    # A few targets are near; none is near both ends of the pipe.
    assert not set(early) & set(late)
    page.find_element("id", "follow").click()
    assert set(scrub(50)) == set(scenario.target_names)
    assert scrub(50) == scrub(950)
    seen = scrub(50)
    across = [seen[name][0] for name in scenario.target_names]
    assert np.corrcoef(across, scenario.target_array()[:, 0])[0, 1] > 0.99
    assert "magnified" in page.find_element("id", "flight-scale").text


def test_a_magnified_agent_does_not_pierce_the_wall(page, run_with_page):
    contents = collect_contents(StoredRun.open(run_with_page))
    data = viewer_data(contents)
    rng = np.random.default_rng(3)
    for agent in data["agents"]:
        attitude = rng.normal(size=4)
        attitude /= np.linalg.norm(attitude)
        angle = rng.uniform(0, 2 * np.pi)
        place = [4.0, 0.97 * np.cos(angle), 0.97 * np.sin(angle)]
        moved = page.execute_script(
            "return moveOffWall(...arguments)",
            agent["outer"],
            attitude.tolist(),
            place,
            data["magnification"],
            data["pipe"],
        )
        angles = np.linspace(0, 2 * np.pi, 100)
        x, r = np.array(agent["outer"]).T[:, :, None]
        body = np.stack(np.broadcast_arrays(x, r * np.cos(angles), r * np.sin(angles)), axis=-1).reshape(-1, 3)
        drawn = moved + data["magnification"] * body @ matrix_from_quaternion(attitude).T
        assert np.hypot(drawn[:, 1], drawn[:, 2]).max() < 1.005
        inside = page.execute_script(
            "return moveOffWall(...arguments)", agent["outer"], attitude.tolist(), [4, 0, 0], 1, data["pipe"]
        )
        assert inside == [4, 0, 0]


def test_the_current_drifts_as_fast_as_the_profile_says(page, run_with_page):
    contents = collect_contents(StoredRun.open(run_with_page))
    flow = PowerLawFlow(speed=1.5, exponent=7)
    scenario = contents.study.scenario.model_copy(update={"flow": flow})
    faster = replace(contents, study=replace(contents.study, scenario=scenario))
    [segment] = viewer_data(faster)["pipe"]
    r = np.linspace(0, 1, len(segment["speeds"]))[:-1]
    # The power law with the bulk speed U: u/U = (n + 1)(2 n + 1) / (2 n^2) (1 - r/R)^(1/n).
    assert segment["speeds"][:-1] == pytest.approx(1.5 * 8 * 15 / 98 * (1 - r) ** (1 / 7))
    before, after = (
        np.array(page.execute_script("return drift([arguments[0]])(arguments[1])", segment, t)).reshape(-1, 6, 3)
        for t in (0, 0.01)
    )
    way = after[:, 1] - before[:, 1]
    stays = way[:, 0] > 0  # The others have left the pipe and come in again.
    assert stays.sum() > 200
    radius = np.hypot(before[:, 1, 1], before[:, 1, 2])
    expected = np.interp(radius, np.linspace(0, 1, len(segment["speeds"])), segment["speeds"])
    assert way[stays, 0] / 0.01 == pytest.approx(expected[stays])
    assert np.abs(way[:, 1:]).max() < 1e-12


def test_the_page_names_the_agents_that_are_outside_of_what_was_tested(run_with_page, monkeypatch):
    contents = collect_contents(StoredRun.open(run_with_page))
    monkeypatch.setitem(RANGES, "a body in a bore", (replace(RANGES["a body in a bore"][0], high=0.0),))
    page = " ".join(page_html(contents).split())
    assert "Outside of what was tested" in page
    for group in contents.agents:
        assert f"<li>{', '.join(entry.target for entry in group)}: a body in a bore: diameter over" in page
    monkeypatch.undo()
    assert "a body in a bore" not in page_html(contents)


def test_the_viewer_has_the_flights_as_they_were_flown(run_with_page):
    contents = collect_contents(StoredRun.open(run_with_page))
    page = page_html(contents)
    for group, agent in zip(contents.agents, viewer_data(contents)["agents"], strict=True):
        entry = group[0]
        assert agent["targets"] == [shared.target for shared in group]
        assert f": mass {entry.agent.mass.mass:.4g} kg, length {entry.agent.body.length:.4g} m, " in page
        t, position = np.array(agent["flight"]["t"]), np.array(agent["flight"]["position"])
        straight = np.column_stack([np.interp(entry.trajectory.t, t, p) for p in position.T])
        # Between 240 moments a flight at 1 m/s goes 4 cm: drawn straight, it cuts a corner at a wall by a quarter.
        assert np.abs(straight - entry.trajectory.position).max() < 0.02
        assert np.linalg.norm(position[t == agent["closest"]] - contents.study.scenario.targets[entry.target]) == (
            pytest.approx(entry.distance, abs=2e-4)
        )


@pytest.mark.parametrize(
    "name", ["</script><script>alert(1)</script>", "<img src=x onerror=alert(1)>", '" onfocus="alert(1)', "&lt;b>"]
)
def test_a_name_from_a_foreign_file_is_text_wherever_the_page_shows_it(run_with_page, name):
    plain = collect_contents(StoredRun.open(run_with_page))
    study, first = plain.study, plain.entries[0]
    result = {**first.stored.result, "target": name}
    renamed = replace(
        plain,
        study=replace(study, document={**study.document, "title": name, "builder": {"use": name}}),
        entries=(replace(first, stored=replace(first.stored, result=result)), *plain.entries[1:]),
        figures={name: "<svg/>"},
    )
    study.scenario.targets[name] = study.scenario.targets[first.target]
    page = PageReader()
    page.feed(page_html(renamed))
    usual = PageReader()
    usual.feed(page_html(replace(plain, figures={"": "<svg/>"})))
    assert page.tags == usual.tags
    # Title, heading, figure, row, button, genome, plugin; the study and the viewer's data hold more.
    assert "".join(page.text).count(name) >= 6
    assert json.loads(page.data)["agents"][0]["targets"][0] == name


class PageReader(HTMLParser):
    """The elements with their attributes' names, the text, and the viewer's data of a page."""

    def __init__(self):
        super().__init__()
        self.tags, self.text, self.data = [], [], ""
        self.is_data = False

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, [key for key, _ in attributes]))
        self.is_data = ("id", "data") in attributes

    def handle_data(self, data):
        if self.is_data:
            self.data += data
        else:
            self.text.append(data)

    def handle_endtag(self, tag):
        self.is_data = False


def test_the_command_prints_the_path_of_the_page(run, run_with_page, tmp_path):
    out = tmp_path / "pages" / "mine.html"
    document = json.loads(run("report", run_with_page, "--out", out, "--json", cwd=tmp_path).stdout)
    assert Path(document["report"]) == out and out.stat().st_size == document["bytes"]
