"""The command line, for formats that are folders."""

from pathlib import Path

from typer.testing import CliRunner

from driftform.cli.app import app

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


def export(folder: Path, *more: str) -> str:
    words = ["export", WORD, "--format", "sdf,uuv,urdf,mjcf", "--out", str(folder), *more]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.stderr
    return result.stdout


def test_it_prints_the_file_to_open_and_counts_the_others(tmp_path: Path) -> None:
    lines = export(tmp_path).splitlines()
    assert len(lines) == 8
    assert [line.partition(":")[0].rpartition("/")[2] for line in lines[:4]] == [
        "world.sdf",
        "start.launch",
        "agent.urdf",
        "scene.xml",
    ]
    for line, suffix in zip(lines[4:], ("sdf", "uuv", "urdf", "mjcf"), strict=True):
        folder, _, count = line.partition(": ")
        assert folder.endswith(f"-{suffix}")
        assert count == f"{sum(path.is_file() for path in Path(folder).rglob('*'))} files"
