"""Where driftform installs from wheels alone. ``UPDATE_DOCS=1 pytest -m installs tests/docs`` rewrites both tables."""

import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

PLATFORMS = {
    "Linux, x86-64": "x86_64-manylinux_2_28",
    "Linux, aarch64": "aarch64-manylinux_2_28",
    "macOS, arm64": "aarch64-apple-darwin",
    "macOS, x86-64": "x86_64-apple-darwin",
    "Windows, x86-64": "x86_64-pc-windows-msvc",
}

PYTHON = "Programming Language :: Python :: 3."


def read(folder):
    return tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))


def say_range(versions):
    """Name the first and the last of some versions that follow each other."""
    first, *rest = versions or ["none"]
    return f"{first} to {rest[-1]}" if rest else first


@pytest.mark.installs
def test_platforms_and_extras_are_those_that_the_pages_name(uv, dist, tmp_path, published):
    document = read(ROOT)
    project, dated = document["project"], document["tool"]["uv"]["exclude-newer"]
    versions = [f"3.{line.removeprefix(PYTHON)}" for line in project["classifiers"] if line.startswith(PYTHON)]
    extras = project["optional-dependencies"]
    named = " ".join(need for needs in extras.values() for need in needs)
    names = {read(path.parent)["project"]["name"] for path in ROOT.glob("plugins/*/pyproject.toml")}
    core = ["driftform", *sorted(name for name in names if name not in named)]
    wanted = {"": core} | {extra: [*core, f"driftform[{extra}]"] for extra in extras}

    def resolves(platform, version, needs):
        # With an interpreter given, uv looks for none of the version asked for.
        running = ("--python", sys.executable)
        options = (*running, "--python-platform", platform, "--python-version", version, "--exclude-newer", dated)
        wheels = ("--only-binary", ":all:", "--find-links", dist)
        done = subprocess.run(
            [uv, "pip", "compile", "-", *options, *wheels],
            input="\n".join(needs),
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0 or "No solution found" in done.stderr, done.stderr
        return done.returncode == 0

    def find_extras(where):
        """What resolves on a platform with a version of Python; most often all of it does, together."""
        platform, version = PLATFORMS[where[0]], where[1]
        if resolves(platform, version, [need for needs in wanted.values() for need in needs]):
            return set(wanted)
        return {extra for extra, needs in wanted.items() if resolves(platform, version, needs)}

    cases = [(platform, version) for platform in PLATFORMS for version in versions]
    with ThreadPoolExecutor(4) as threads:
        found = dict(zip(cases, threads.map(find_extras, cases), strict=True))
    short, long = ["| platform | Python |", "|---|---|"], ["| platform | Python | extras |", "|---|---|---|"]
    for platform in PLATFORMS:
        by_extra = {extra: [v for v in versions if extra in found[platform, v]] for extra in wanted}
        fewer = [f"`{e}`: {say_range(some)}" for e, some in by_extra.items() if some != by_extra[""]]
        short.append(f"| {platform} | {say_range(by_extra[''])} |")
        long.append(f"| {platform} | {say_range(by_extra[''])} | {'; '.join(fewer) or 'all'} |")
        assert by_extra[""], f"driftform has no wheels for {platform}"
    published("platforms", short, ROOT / "README.md")
    published("platforms", long, ROOT / "docs" / "start.md")
