"""What stands beside the code: licence, citation, changelog."""

import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PLUGINS = sorted(path.parent for path in (ROOT / "plugins").glob("*/pyproject.toml"))


@pytest.mark.parametrize("plugin", PLUGINS, ids=lambda path: path.name)
def test_a_plugin_has_the_licence_of_the_whole_and_a_readme_of_its_own(plugin: Path) -> None:
    assert (plugin / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert (plugin / "README.md").read_text(encoding="utf-8").startswith(f"# {plugin.name}\n")


def test_the_citation_is_of_this_version_and_of_the_paper() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert citation["version"] == project["version"] and citation["license"] == project["license"]
    [author], [paper] = citation["authors"], citation["references"]
    assert f"*{paper['title']}*" in readme and paper["authors"]
    year = citation["date-released"].year
    for line in (
        f"author = {{{{{author['name']}}}}}",
        f"year = {{{year}}}",
        f"version = {{{project['version']}}}",
    ):
        assert line in readme


def test_the_changelog_tells_of_this_version() -> None:
    from driftform import __version__

    assert f"\n## {__version__}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
