"""Which way imports point: the command line stands on the package, and plugins stand on the package too."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
CORE = ROOT / "src" / "driftform"
CLI = CORE / "cli"


def imported(source: str) -> Iterator[str]:
    """Every module that a source names in an import, also inside functions, and each name after ``from``."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "a relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def importers(files: Iterator[Path], *packages: str) -> list[str]:
    """The files that import one of the packages, or from it."""
    return [
        f"{file.relative_to(ROOT)} imports {name}"
        for file in files
        for name in imported(file.read_text(encoding="utf-8"))
        if any(name == package or name.startswith(f"{package}.") for package in packages)
    ]


def test_nothing_outside_the_command_line_imports_it() -> None:
    core = (file for file in CORE.rglob("*.py") if not file.is_relative_to(CLI))
    assert importers(core, "driftform.cli", "typer") == []
    assert importers(ROOT.glob("plugins/*/src/**/*.py"), "driftform.cli", "typer") == []


def test_the_package_imports_no_plugin() -> None:
    plugins = [folder.name.replace("-", "_") for folder in (ROOT / "plugins").iterdir() if folder.is_dir()]
    assert "driftform_native" in plugins
    assert importers(CORE.rglob("*.py"), *plugins) == []


def test_an_import_is_found_wherever_it_stands() -> None:
    source = "import driftform.cli.app\n\ndef late():\n    from driftform import cli\n    from driftform.cli.kit import x\n"
    assert [*imported(source)] == ["driftform.cli.app", "driftform.cli", "driftform.cli.kit.x"]
    assert importers(CLI.glob("app.py"), "typer")
