"""``driftform --help`` is quick because importing the command line imports nothing heavy."""

import subprocess
import sys

HEAVY = (
    "numpy",
    "numba",
    "pydantic",
    "scipy",
    "exudyn",
    "trimesh",
    "manifold3d",
    "rich.live",
    "sqlite3",
    "distributed",
)


def modules_after(statement: str) -> set[str]:
    code = f"import sys\n{statement}\nprint(*sys.modules, sep='\\n')"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    return set(out.split())


def test_importing_the_command_line_imports_nothing_heavy() -> None:
    loaded = modules_after("import driftform.cli")
    assert "driftform.cli.evolve" in loaded
    assert loaded.isdisjoint(HEAVY)


def test_importing_the_package_imports_almost_nothing() -> None:
    assert modules_after("import driftform").isdisjoint({*HEAVY, "typer", "rich"})
