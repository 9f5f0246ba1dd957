"""Which way imports point: each package imports only those below it, and no two modules import each other."""

from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from imports import find_rooms, list_imports, read_imports

ROOT = Path(__file__).parents[2]
CORE = ROOT / "src" / "driftform"
PLUGINS = sorted(path.parent for path in ROOT.glob("plugins/*/src/*/__init__.py"))

HOOKS = "src/driftform/plugins/hookspecs.py"
"""It names the type of the command line's parser, for hints alone."""

CONTRACT = "src/driftform/testing/commands.py"
"""It calls the commands that a plugin adds."""

LAYERS = (
    *("errors", "types", "agent", "util", "water", "interfaces", "motion", "plugins", "pipeline", "study"),
    *("runs", "builtin", "figures", "search", "design", "api", "cli", "testing"),
)
"""The modules and packages of the core from the ground up: each may import those before it, and no others."""

MAX_ROOMS_AND_FLOORS = {"driftform": (18, 13), "driftform.motion": (3, 3)}


def find_forbidden(imports):
    """Imports of the core that point upward, one line each."""
    place = {name: number for number, name in enumerate(LAYERS)}
    return [
        f"{module} imports {name}"
        for module, names in sorted(imports.items())
        for name in sorted(names)
        if module != "driftform" and place[name.split(".")[1]] > place[module.split(".")[1]]
    ]


def count_floors(rooms):
    """The number of rooms in the longest chain of which each imports the next."""

    def find_floor(room):
        return 1 + max(map(find_floor, rooms[room]), default=0)

    return max(map(find_floor, rooms))


def test_every_part_of_the_core_has_its_layer():
    parts = {path.stem for path in CORE.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()}
    assert parts - {"__init__", "__main__"} == set(LAYERS)


@pytest.mark.parametrize("package", MAX_ROOMS_AND_FLOORS)
def test_a_package_has_few_rooms_on_few_floors(package):
    rooms = find_rooms(read_imports(CORE), package)
    found = len(rooms), count_floors(rooms)
    print("{}: {} rooms on {} floors".format(package, *found))
    assert found <= MAX_ROOMS_AND_FLOORS[package] and found[1] <= MAX_ROOMS_AND_FLOORS[package][1]


def test_floors_are_counted_along_the_longest_chain():
    imports = {
        "driftform.a.x": {"driftform.b.y", "driftform.c"},
        "driftform.b.y": {"driftform.c", "driftform.b.z"},
        "driftform.b.z": set[str](),
        "driftform.c": set[str](),
    }
    assert count_floors(find_rooms(imports)) == 3
    assert find_rooms(imports, "driftform.b") == {"y": {"z"}, "z": set()}


def test_each_part_of_the_core_imports_only_those_below_it():
    assert find_forbidden(read_imports(CORE)) == []


def test_the_parts_of_a_pipe_know_nothing_of_the_water_in_it():
    inner, outer = "driftform.water.parts", "driftform.water."
    imports = {module: names for module, names in read_imports(CORE).items() if module.startswith(inner)}
    assert len(imports) > 10
    found = {module: {name for name in names if name.startswith(outer)} for module, names in imports.items()}
    assert [module for module, names in found.items() if any(not name.startswith(inner) for name in names)] == []


def test_an_import_that_points_upward_is_found_also_inside_a_function():
    source = "def fly():\n    from driftform.cli import app\n    import driftform.runs.store\n"
    imports = {"driftform.motion.path.trajectory": set(list_imports(source))}
    assert find_forbidden(imports) == [
        "driftform.motion.path.trajectory imports driftform.cli.app",
        "driftform.motion.path.trajectory imports driftform.runs.store",
    ]


@pytest.mark.parametrize("package", [CORE, *PLUGINS], ids=lambda path: path.name)
def test_no_modules_import_each_other_in_a_circle(package):
    # Raises CycleError with the circle.
    TopologicalSorter(read_imports(package)).prepare()


def test_the_core_imports_no_plugin():
    names = {path.name for path in PLUGINS}
    assert "driftform_native" in names
    found = {name.split(".")[0] for file in CORE.rglob("*.py") for name in list_imports(file.read_text("utf-8"))}
    assert found & names == set()


def test_in_the_core_only_the_command_line_imports_its_parser():
    users = {
        file.relative_to(ROOT).as_posix()
        for file in CORE.rglob("*.py")
        for name in list_imports(file.read_text("utf-8"))
        if name.split(".")[0] == "typer" or name.startswith("driftform.cli")
    }
    assert users and all(user.startswith("src/driftform/cli/") for user in users - {HOOKS, CONTRACT})
