"""What package indexes and code hosts show of the project: authors, links, versions of Python, workflows and forms."""

import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[2]
PROJECTS = [ROOT, *sorted(path.parent for path in (ROOT / "plugins").glob("*/pyproject.toml"))]
PYTHON = "Programming Language :: Python :: 3."


def read_project(folder: Path) -> dict[str, Any]:
    table: dict[str, Any] = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return table


def read_yaml(*parts: str) -> Any:
    return yaml.safe_load(ROOT.joinpath(*parts).read_text(encoding="utf-8"))


def read_workflow(name: str) -> dict[str, Any]:
    workflow: dict[str, Any] = read_yaml(".github", "workflows", name)
    return workflow


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda path: path.name)
def test_every_distribution_has_authors_and_links(folder: Path) -> None:
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
def test_every_distribution_names_the_versions_of_python_that_the_workflow_tests(folder: Path) -> None:
    tested = read_workflow("ci.yml")["jobs"]["tests"]["strategy"]["matrix"]["python"]
    project = read_project(folder)
    named = [
        line.removeprefix("Programming Language :: Python :: ")
        for line in project["classifiers"]
        if line.startswith(PYTHON)
    ]
    assert named == tested
    assert project["requires-python"] == f">={tested[0]}"


def test_the_citation_names_the_authors_of_the_distributions() -> None:
    assert read_yaml("CITATION.cff")["authors"] == read_project(ROOT)["authors"]


def test_the_workflow_tests_on_three_systems_and_runs_what_ci_runs() -> None:
    jobs = read_workflow("ci.yml")["jobs"]
    systems = jobs["tests"]["strategy"]["matrix"]["os"]
    assert [system.split("-")[0] for system in systems] == ["ubuntu", "macos", "windows"]
    assert "uv run pytest" in [step.get("run") for step in jobs["tests"]["steps"]]
    assert "bash .ci/run" in [step.get("run") for step in jobs["complete"]["steps"]]


def test_a_release_is_published_without_a_stored_token() -> None:
    jobs = read_workflow("release.yml")["jobs"]
    assert any("uv build --all-packages" in step.get("run", "") for step in jobs["build"]["steps"])
    publish = jobs["publish"]
    assert publish["environment"] and publish["permissions"] == {"id-token": "write"}
    assert any(
        step["uses"].startswith("pypa/gh-action-pypi-publish@") and "with" not in step
        for step in publish["steps"]
    )


def test_a_commit_is_checked_by_the_lints_of_ci() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    [local] = read_yaml(".pre-commit-config.yaml")["repos"]
    assert local["repo"] == "local"
    assert {hook["id"] for hook in local["hooks"]} == {"ruff", "ruff-format", "mypy"}
    for command in ("uv run ruff check", "uv run ruff format", "uv run mypy"):
        assert any(hook["entry"].startswith(command) for hook in local["hooks"])
        assert f"\n{command}" in script


@pytest.mark.parametrize("form", ["bug.yml", "feature.yml"])
def test_a_form_for_issues_has_a_name_and_unique_fields(form: str) -> None:
    document = read_yaml(".github", "ISSUE_TEMPLATE", form)
    assert document["name"] and document["description"]
    fields = [field["id"] for field in document["body"]]
    assert len(fields) == len(set(fields)) > 0
    assert all(field["attributes"]["label"] for field in document["body"])
