"""How large the core, the plugins and the tests are: lines in all, in each package, and in the longest function."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
CORE = ROOT / "src" / "driftform"
PLUGINS = sorted(path.parent for path in ROOT.glob("plugins/*/src/*/__init__.py"))
PACKAGES = [*sorted(path.parent for path in CORE.glob("*/__init__.py")), *PLUGINS]

MAX_LINES, MAX_LINES_OF_PACKAGE, MAX_LINES_OF_FUNCTION = 32_100, 5_700, 120

MAX_LINES_WITH_PLUGINS, MAX_LINES_OF_TESTS = 60_500, 51_930


def count_lines(folder):
    """The lines of all Python files below a folder."""
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in folder.rglob("*.py"))


def measure_functions(source):
    """The lines of each function and method of a source, with its decorators and docstring, and its name."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
            yield (node.end_lineno or first) - first + 1, node.name


def test_the_core_and_the_plugins_are_small():
    core, plugins = count_lines(CORE), sum(map(count_lines, PLUGINS))
    print(f"{core} lines of the core, {core + plugins} with the plugins")
    assert PLUGINS
    assert core <= MAX_LINES
    assert core + plugins <= MAX_LINES_WITH_PLUGINS


def test_the_tests_are_small():
    tests = sum(map(count_lines, [ROOT / "tests", *ROOT.glob("plugins/*/tests")]))
    print(f"{tests} lines of tests")
    assert tests <= MAX_LINES_OF_TESTS


def test_no_package_is_large():
    lines = {package.name: count_lines(package) for package in PACKAGES}
    print(", ".join(f"{name} {count}" for name, count in sorted(lines.items(), key=lambda row: -row[1])))
    assert {name: count for name, count in lines.items() if count > MAX_LINES_OF_PACKAGE} == {}


def test_no_function_is_long():
    found = [
        (lines, f"{file.relative_to(ROOT)}: {name}")
        for package in (CORE, *PLUGINS)
        for file in package.rglob("*.py")
        for lines, name in measure_functions(file.read_text(encoding="utf-8"))
    ]
    print("longest function: {} lines, {}".format(*max(found)))
    assert [row for row in sorted(found, reverse=True) if row[0] > MAX_LINES_OF_FUNCTION] == []


def test_a_function_is_measured_with_its_decorators():
    source = "@cache\n@other\ndef fly():\n    pass\n\n\nclass A:\n    def swim(self):\n        return 1\n"
    assert sorted(measure_functions(source)) == [(2, "swim"), (4, "fly")]
