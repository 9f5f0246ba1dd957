"""What package indexes and code hosts show of the project: authors, links, versions, workflows, licence and citation."""

import re
import subprocess
import tomllib
from itertools import chain
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PROJECTS = [ROOT, *sorted(path.parent for path in (ROOT / "plugins").glob("*/pyproject.toml"))]
PYTHON = "Programming Language :: Python :: 3."
AT_THE_TOP = {
    ".ci", ".github", ".gitignore", ".pre-commit-config.yaml", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE",
    "README.md", "docs", "mkdocs.yml", "plugins", "pyproject.toml", "src", "tests",
}  # fmt: skip
LARGEST = 1_000_000
"""Bytes of a file that is kept."""


def read_project(folder):
    return tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def read_yaml(*parts):
    return yaml.safe_load(ROOT.joinpath(*parts).read_text(encoding="utf-8"))


def read_workflow(name):
    return read_yaml(".github", "workflows", name)


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda path: path.name)
def test_every_distribution_has_authors_and_links(folder):
    project = read_project(folder)
    assert project["authors"] == [{"name": "The driftform developers"}]
    urls = project["urls"]
    assert urls.keys() >= {"Homepage", "Documentation", "Issues", "Changelog"}
    assert urls == read_project(ROOT)["urls"]
    for url in urls.values():
        assert url.startswith("https://github.com/driftform/driftform")
        _, found, path = url.partition("/main/")
        assert not found or (ROOT / path).exists(), url


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda path: path.name)
def test_every_distribution_names_the_versions_of_python_that_the_workflow_tests(folder):
    tested = read_workflow("ci.yml")["jobs"]["tests"]["strategy"]["matrix"]["python"]
    project = read_project(folder)
    named = [
        line.removeprefix("Programming Language :: Python :: ")
        for line in project["classifiers"]
        if line.startswith(PYTHON)
    ]
    assert named == tested
    assert project["requires-python"] == f">={tested[0]}"


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda path: path.name)
def test_every_distribution_needs_the_others_of_its_own_version(folder):
    project = read_project(folder)
    needs = [*project["dependencies"], *chain(*project.get("optional-dependencies", {}).values())]
    ours = [need for need in needs if need.startswith("driftform")]
    assert ours and all(need.endswith(f"=={project['version']}") for need in ours)
    assert project["version"] == read_project(ROOT)["version"]


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda path: path.name)
def test_packages_whose_internals_are_used_have_an_upper_bound(folder):
    bounded = {"cadquery-ocp-novtk", "exudyn", "manifold3d", "numba", "pydantic", "resvg-py", "ribs", "rosbags"}
    project = read_project(folder)
    needs = [*project["dependencies"], *chain(*project.get("optional-dependencies", {}).values())]
    assert [n for n in needs if re.match(r"[\w-]+", n)[0] in {*bounded, "trimesh", "typer"} and ",<" not in n] == []


def test_the_core_installs_every_plugin_of_the_default_study():
    needs = {need.partition("==")[0] for need in read_project(ROOT)["dependencies"]}
    optional = {folder.name for folder in PROJECTS[1:]} - needs
    assert optional == {
        "driftform-networks",
        "driftform-pymoo",
        "driftform-ribs",
        "driftform-robotics",
        "driftform-ros",
        "driftform-studio",
    }
    for name in optional:
        assert any(need.startswith(name) for need in read_project(ROOT)["optional-dependencies"][name[10:]])


def test_the_workflow_tests_on_three_systems_and_runs_what_ci_runs():
    jobs = read_workflow("ci.yml")["jobs"]
    systems = jobs["tests"]["strategy"]["matrix"]["os"]
    assert [system.split("-")[0] for system in systems] == ["ubuntu", "macos", "windows"]
    assert "uv run pytest" in [step.get("run") for step in jobs["tests"]["steps"]]
    assert "bash .ci/run" in [step.get("run") for step in jobs["complete"]["steps"]]


def test_ci_runs_every_group_of_tests_that_is_not_slow(pytestconfig):
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "pip install uv && uv run pytest\n" in (ROOT / "README.md").read_text(encoding="utf-8")
    assert 'bash -c "$test_command"\n' in script and "uv sync --quiet --all-groups\n" in script
    [default] = [word for word in pytestconfig.getini("addopts") if word.startswith("not slow")]
    groups = {
        line.partition(":")[0] for line in pytestconfig.getini("markers") if f"not {line.partition(':')[0]}" in default
    }
    selections = {
        "long": '"long and not peers and not slow and not installs"',
        "peers": '"peers and not slow"',
        "installs": "installs",
    }
    assert groups == {"slow", *selections}
    for selection in selections.values():
        assert f"uv run pytest -m {selection}" in script


def test_the_files_of_tests_that_ci_names_are_there():
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    named = [
        f"{before}{name}{after}"
        for before, names, after in re.findall(r"(\S+/test_)\{([\w,]+)\}(\.py)", script)
        for name in names.split(",")
    ]
    assert len(named) > 10
    assert [name for name in named if not (ROOT / name).is_file()] == []


def test_a_release_is_published_without_a_stored_token():
    jobs = read_workflow("release.yml")["jobs"]
    assert any("uv build --all-packages" in step.get("run", "") for step in jobs["build"]["steps"])
    publish = jobs["publish"]
    assert publish["environment"] and publish["permissions"] == {"id-token": "write"}
    assert any(
        step["uses"].startswith("pypa/gh-action-pypi-publish@") and "with" not in step for step in publish["steps"]
    )


def test_a_commit_is_checked_by_the_lints_of_ci():
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    [local] = read_yaml(".pre-commit-config.yaml")["repos"]
    assert local["repo"] == "local"
    assert {hook["id"] for hook in local["hooks"]} == {"ruff", "ruff-format", "mypy"}
    for command in ("ruff check", "ruff format", "mypy"):
        assert any(hook["entry"].startswith(f"uv run --group lint {command}") for hook in local["hooks"])
        assert f"\nuv run {command}" in script


def test_the_extra_studio_is_all_that_brings_a_server():
    project = read_project(ROOT)
    names = {need.partition("=")[0].partition(">")[0] for need in project["dependencies"]}
    assert not names & {"driftform-studio", "starlette", "uvicorn", "fastapi", "nicegui"}
    assert project["optional-dependencies"]["studio"] == [f"driftform-studio=={project['version']}"]


def test_nothing_else_and_nothing_large_is_kept():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True).stdout
    kept = [ROOT / name for name in listed.split("\0") if name]
    assert {path.relative_to(ROOT).parts[0] for path in kept} == AT_THE_TOP
    assert max(path.stat().st_size for path in kept if path.exists()) <= LARGEST


@pytest.mark.parametrize("plugin", PROJECTS[1:], ids=lambda path: path.name)
def test_a_plugin_has_the_licence_of_the_whole_and_a_readme_of_its_own(plugin):
    assert (plugin / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()
    assert (plugin / "README.md").read_text(encoding="utf-8").startswith(f"# {plugin.name}\n")


def test_the_citation_is_of_this_version_and_of_the_paper():
    citation, project = read_yaml("CITATION.cff"), read_project(ROOT)
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
