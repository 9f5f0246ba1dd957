"""``driftform --help`` and ``driftform plugins list`` are quick because they import nothing heavy."""

import subprocess
import sys

import pytest

SHOWING_AND_STORING = ("rich", "sqlite3", "distributed", "starlette", "uvicorn")
HEAVY = ("numpy", "numba", "pydantic", "scipy", "exudyn", "trimesh", "manifold3d", *SHOWING_AND_STORING)
FOR_WORK = (
    *(
        "driftform.util.compiled",
        "driftform.search.loop",
        "driftform.search.jobs",
        "numba",
        "scipy",
        "exudyn",
        "matplotlib",
    ),
    *("trimesh", "OCP", "rosbags", "pymoo", "ribs", "pyarrow", *SHOWING_AND_STORING),
)
"""What plugins and commands need for their work, and not to be listed."""


def modules_after(statement):
    code = f"import sys\n{statement}\nprint(*sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    return set(out.splitlines()[-1].split())


def test_importing_the_command_line_imports_nothing_heavy():
    loaded = modules_after("import driftform.cli.app")
    assert "driftform.cli.evolve" in loaded
    assert loaded & set(HEAVY) == set()


def test_importing_the_package_imports_almost_nothing():
    assert modules_after("import driftform") & {*HEAVY, "typer"} == set()


def after_running(*arguments):
    """Modules that are there when a command has ended well."""
    return modules_after(
        "from driftform.cli.app import app\n"
        f"try: app({list(arguments)!r})\n"
        "except SystemExit as end: assert end.code == 0"
    )


@pytest.mark.parametrize("page", [["--help"], ["evolve", "paper", "--help"], ["plugins", "list", "--help"]])
def test_a_help_page_imports_nothing_heavy(page):
    # To find a command, typer reads the options before its name, and checks them by pydantic.
    expected = {"pydantic"} if len(page) > 1 else set()
    assert after_running(*page) & set(HEAVY) == expected


def test_plugins_are_listed_without_what_only_their_work_needs():
    loaded = after_running("plugins", "list")
    # Their classes are there, so that a plugin that cannot be imported shows.
    assert {"driftform_exudyn.simulator", "driftform_native.simulator", "driftform.builtin.fitness"} <= loaded
    assert loaded & set(FOR_WORK) == set()


def test_commands_that_open_agents_and_runs_import_no_large_package_of_scipy():
    loaded = modules_after(
        "import driftform.design.opening, driftform.search.report.page, driftform.search.picking\n"
        "from driftform.study import load_study\n"
        "from driftform.search.disturbed import draw_rounds\n"
        "draw_rounds(load_study('pipe-inspection', run={'seed': 0}))"
    )
    assert loaded & {"scipy.stats", "scipy.optimize", "scipy.linalg"} == set()
