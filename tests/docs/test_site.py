"""The site of the docs is built with warnings as errors, and holds every page."""

import re
from pathlib import Path

import pytest
from accessibility import find_barriers, look

ROOT = Path(__file__).parents[2]


def text_of(site, page):
    return (site / page / "index.html").read_text(encoding="utf-8")


def test_every_page_is_in_the_navigation(pages):
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    listed = re.findall(r": (\S+\.md)$", nav, re.MULTILINE)
    assert sorted(listed) == sorted(pages)


def test_pictures_are_there(site):
    for page in site.rglob("index.html"):
        for source in re.findall(r'<img[^>]* src="([^"]+)"', page.read_text(encoding="utf-8")):
            assert (page.parent / source).exists(), f"{page}: {source}"


def test_fenced_blocks_are_blocks_and_show_their_file(site):
    assert not [page for page in site.rglob("index.html") if "```" in page.read_text(encoding="utf-8")]
    assert "src/driftform_dwell/dwell.py</span>" in text_of(site, "write-a-plugin")


def test_the_site_opens_with_the_picture_and_four_doors(site):
    home = text_of(site, "").partition("<article")[2].partition("<h2")[0]
    assert 'src="images/flight.png"' in home and "driftform evolve" in re.sub("<[^>]+>", "", home)
    doors = home.partition('<div class="grid cards">')[2]
    assert re.findall(r'<strong><a href="([^"]+)"', doors) == ["studio/", "start/", "write-a-plugin/", "printing/"]


def test_pages_for_users_hold_no_commands_for_developers(pages):
    for name, text in pages.items():
        assert not re.search(r"UPDATE_DOCS|uv run pytest|pytest -m|pre-commit", text), name


FEW = """
document.querySelectorAll("article > h3, article > p, article > div, article > ul").forEach((e, i) => { if (i > 400) e.remove(); });
document.querySelectorAll("nav li.md-nav__item").forEach((e, i) => { if (i > 150) e.remove(); });
"""
"""Leaves four of the modules of the reference, and as much of its contents."""


@pytest.mark.slow
def test_axe_finds_no_barrier_on_any_page(site, browser):
    # What this page names is at the root of a server, which a folder is not.
    lost = site / "404.html"
    lost.write_text(lost.read_text(encoding="utf-8").replace('="/', '="'), encoding="utf-8")
    browser.set_script_timeout(100)
    found = {}
    for number, page in enumerate(sorted(site.rglob("*.html"))):
        browser.get(page.as_uri())
        if page.parent.name == "reference":
            # One template makes all of its modules; all of them take minutes.
            browser.execute_script(FEW)
        # Each page in both widths and both schemes; what all pages have in common, in all four pairs.
        schemes = ("light", "dark") if number % 2 else ("dark", "light")
        for width, scheme in zip((390, 1280), schemes, strict=True):
            look(browser, width, scheme)
            if barriers := find_barriers(browser):
                found[f"{page.relative_to(site)}, {width}, {scheme}"] = barriers
    assert found == {}
