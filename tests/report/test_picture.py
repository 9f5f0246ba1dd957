"""The picture of a page in docs/start.md. ``UPDATE_DOCS=1 pytest -m slow tests/report`` takes it anew."""

import base64
import os
import struct
from pathlib import Path

import pytest
from typer.testing import CliRunner

from driftform.cli.app import app

PICTURE = Path(__file__).parents[2] / "docs" / "images" / "report.png"
WIDTH, SHOWN = 1200, "TP6"


@pytest.fixture
def shown(browser, tmp_path, monkeypatch):
    """The page of the run of docs/start.md, opened at an agent in the middle of its flight."""
    monkeypatch.chdir(tmp_path)
    for command in ("evolve --simulator native --seed 1 --out r1", "report r1"):
        result = CliRunner().invoke(app, command.split())
        assert result.exit_code == 0, result.output
    size = {"width": WIDTH, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    light = {"name": "prefers-color-scheme", "value": "light"}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [light]})
    browser.get((tmp_path / "r1" / "report.html").as_uri())
    [choice] = [
        button for button in browser.find_elements("css selector", "[data-agent]") if button.text.strip() == SHOWN
    ]
    choice.click()
    return browser


@pytest.mark.slow
def test_the_picture_of_a_page_is_its_head_down_to_the_flight(shown):
    bottom = shown.execute_script(
        "return Math.ceil(Math.max(...['agent-view', 'flight-view'].map("
        "(id) => document.getElementById(id).closest('.card').getBoundingClientRect().bottom)) + window.scrollY)"
    )
    clip = {"x": 0, "y": 0, "width": WIDTH, "height": bottom + 16, "scale": 1}
    asked = {"format": "png", "clip": clip, "captureBeyondViewport": True}
    picture = base64.b64decode(shown.execute_cdp_cmd("Page.captureScreenshot", asked)["data"])
    if os.environ.get("UPDATE_DOCS") == "1":
        PICTURE.write_bytes(picture)
    kept = PICTURE.read_bytes()
    assert len(kept) < 300_000
    width, height = struct.unpack(">II", kept[16:24])
    assert width == WIDTH
    assert height == pytest.approx(struct.unpack(">I", picture[20:24])[0], abs=40)
