"""``driftform studio`` comes with an extra, which alone brings a server."""

import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_extra_is_all_that_brings_a_server():
    names = {need.partition("=")[0].partition(">")[0] for need in PROJECT["dependencies"]}
    assert not names & {"driftform-studio", "starlette", "uvicorn", "fastapi", "nicegui"}
    assert PROJECT["optional-dependencies"]["studio"] == [f"driftform-studio=={PROJECT['version']}"]
