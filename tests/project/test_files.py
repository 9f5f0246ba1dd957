"""What stands beside the code: licence, citation, changelog."""

import subprocess
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
AT_THE_TOP = {
    ".ci", ".github", ".gitignore", ".pre-commit-config.yaml", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE",
    "README.md", "docs", "mkdocs.yml", "plugins", "pyproject.toml", "src", "tests",
}  # fmt: skip
LARGEST = 1_000_000
"""Bytes of a file that is kept."""

PLUGINS = sorted(path.parent for path in (ROOT / "plugins").glob("*/pyproject.toml"))


def test_nothing_else_and_nothing_large_is_kept():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True).stdout
    kept = [ROOT / name for name in listed.split("\0") if name]
    assert {path.relative_to(ROOT).parts[0] for path in kept} == AT_THE_TOP
    assert max(path.stat().st_size for path in kept if path.exists()) <= LARGEST


@pytest.mark.parametrize("plugin", PLUGINS, ids=lambda path: path.name)
def test_a_plugin_has_the_licence_of_the_whole_and_a_readme_of_its_own(plugin):
    assert (plugin / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert (plugin / "README.md").read_text(encoding="utf-8").startswith(f"# {plugin.name}\n")


def test_the_citation_is_of_this_version_and_of_the_paper():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert citation["authors"] == project["authors"]
    assert citation["version"] == project["version"] and citation["license"] == project["license"]
    [author], [paper] = citation["authors"], citation["references"]
    assert f"*{paper['title']}*" in readme and paper["authors"]
    year = citation["date-released"].year
    for line in (f"author = {{{{{author['name']}}}}}", f"year = {{{year}}}", f"version = {{{project['version']}}}"):
        assert line in readme


def test_the_changelog_tells_of_this_version():
    from driftform import __version__

    assert f"\n## {__version__}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
