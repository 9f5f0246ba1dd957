"""Change one operator or constant of a core formula at a time, and list the changes that no test finds.

    uv run python tests/mutations.py [--only NAME] [--count 60] [--seed 0]
    uv run python tests/mutations.py --chosen [--only NAME]

The second command makes the changes of ``tests/mutants.toml``, which reach all over the house; with UPDATE_DOCS=1 it writes
their table in docs/validation.md.

A mutant is another source of one file, which a child process imports in place of that on the disk; the working tree stays
as it is. The child runs the tests of that file. A test that fails, an error, or a run beyond the time limit kills the
mutant; mutants that live are printed, and the exit code is 1. Kernels run as plain Python where mutants are drawn, because
each would compile for tens of seconds: the tests of a file are therefore those that call its functions, and not whole
flights. No chosen change is in a kernel.

Children are forks of a process that has imported the large packages, so this needs Linux or macOS; the tests of networks
need `uv sync --all-groups`.
"""

import argparse
import ast
import copy
import importlib
import importlib.abc
import importlib.util
import math
import os
import random
import signal
import sys
import tempfile
import time
import tomllib
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from pathlib import Path

ROOT = Path(__file__).parents[1]
CHOSEN, PAGE = ROOT / "tests" / "mutants.toml", ROOT / "docs" / "validation.md"

LIMIT_S = 1800
"""Time limit of the tests of a file that is unchanged, CPU s."""

LONGER, MIN_LIMIT_S = 3, 60
"""Time limit of a mutant over the time of the file unchanged, and the least, CPU s."""

PACKAGES = (
    "hypothesis.extra.numpy",
    "numpy",
    "pytest",
    "scipy.integrate",
    "scipy.optimize",
    "scipy.sparse.linalg",
    "scipy.spatial.transform",
    "scipy.stats",
    "typer",
)
"""What most tests import."""

MARKS, QUICK_MARKS = "not slow and not installs", "not slow and not installs and not long"
"""Tests that judge the drawn mutants, and the chosen ones."""


@dataclass(frozen=True)
class Target:
    """A file of formulas, the tests that judge it, and the functions that count as formulas."""

    path: str
    tests: tuple[str, ...]
    functions: tuple[str, ...] = ()
    """Without any, the whole file."""
    marks: str = MARKS

    @property
    def name(self):
        """Name by which ``--only`` selects it."""
        return Path(self.path).stem

    @property
    def module(self):
        """Name of the module."""
        return ".".join(Path(self.path.rpartition("src/")[2]).with_suffix("").parts)


AGENT, FORCES, PLUGINS = "src/driftform/agent", "src/driftform/motion/forces", "plugins/driftform"
FORMULAS = "tests/motion/test_drag_formulas.py"
STRIPS = f"{PLUGINS}-striptheory/src/driftform_striptheory"
NETWORKS = f"{PLUGINS}-networks/src/driftform_networks"

TARGETS = (
    Target(f"{AGENT}/solids.py", ("tests/agent/test_solids.py",)),
    Target(f"{AGENT}/mass.py", ("tests/agent/test_mass.py",)),
    Target(f"{AGENT}/mass_elements.py", ("tests/agent/test_mass_elements.py",)),
    Target(f"{FORCES}/drag_coefficients.py", (FORMULAS, "tests/motion/test_body_drag.py")),
    Target(f"{FORCES}/body_drag.py", (FORMULAS, "tests/motion/test_body_drag.py")),
    Target(f"{FORCES}/drag.py", (FORMULAS, "tests/motion/test_drag.py", "tests/motion/test_creeping.py")),
    Target(f"{FORCES}/creeping.py", ("tests/motion/test_creeping.py",)),
    Target(f"{FORCES}/inertia.py", ("tests/motion/test_inertia.py",)),
    Target("src/driftform/water/scenario.py", ("tests/water/test_scenario.py",), ("load",)),
    Target(f"{STRIPS}/coefficients.py", (f"{PLUGINS}-striptheory/tests/test_coefficients.py",)),
    Target(f"{STRIPS}/ellipsoid.py", (f"{PLUGINS}-striptheory/tests/test_ellipsoid.py",)),
    Target(f"{FORCES}/impact.py", ("tests/motion/test_impact.py",)),
    Target(f"{FORCES}/contact.py", ("tests/motion/test_contact.py", "tests/motion/test_friction.py")),
    Target(
        f"{PLUGINS}-calibration/src/driftform_calibration/solution.py",
        (f"{PLUGINS}-calibration/tests/test_solution.py",),
        ("anchor", "merge_solutions", "_spread", "_list_residuals", "estimate_covariance", "correlation_time"),
    ),
    Target(f"{NETWORKS}/passages/passage.py", (f"{PLUGINS}-networks/tests/test_chain.py",)),
    Target(f"{NETWORKS}/flights/junctions.py", (f"{PLUGINS}-networks/tests/test_dividing.py",)),
)

EQUIVALENT = {
    "contact.axis_in_bore: 0.0 -> 1.0": "these numbers are not read in a pipe with parts",
    "contact.wall_wrench: 1.0 -> 1.1": "any negative number ends the list of touches",
    "contact.wall_wrench: pressed += energy * force -> pressed -= energy * force": "only its square is used",
}
"""Mutants that compute the same, or differ by less than the formula itself is known, with the reason."""


@dataclass(frozen=True)
class Mutant:
    """A file with one change; ``label`` names the function, and what was there and what is there now.

    ``reason`` says why no test can find it, if none can.
    """

    target: Target
    line: int
    label: str
    source: str
    reason: str = ""

    @property
    def package(self):
        """Name of the plugin, or of the package of the core."""
        parts = Path(self.target.path).parts
        return parts[1] if parts[0] == "plugins" else f"`{parts[2]}`"


# The changes.

_SWAPS = {
    **{ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult},
    **{ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq},
}
_DIMENSIONLESS_KEYWORDS = {"axis", "keepdims", "maxsize", "copy", "dtype", "strict"}


def change_node(node):
    """Generate what may take the place of one node of the syntax tree."""
    match node:
        case ast.BinOp(left, op, right) if type(op) in _SWAPS:
            yield ast.BinOp(left, _SWAPS[type(op)](), right)
            yield left
            if isinstance(op, (ast.Add, ast.Mult)):
                yield right
        case ast.AugAssign(place, op, value) if type(op) in _SWAPS:
            yield ast.AugAssign(place, _SWAPS[type(op)](), value)
        case ast.Compare(left, [op], rest) if type(op) in _SWAPS:
            yield ast.Compare(left, [_SWAPS[type(op)]()], rest)
        case ast.UnaryOp(ast.USub(), operand):
            yield operand
        case ast.Constant(value) if type(value) is int:
            yield ast.Constant(value + 1)
        case ast.Constant(value) if type(value) is float:
            yield ast.Constant(float(f"{1.1 * value:.6g}") or 1.0)


def list_places(tree, scope=""):
    """Generate the fields of the syntax tree that hold a formula's nodes: parent, field, index in it or None, function."""
    for field, value in ast.iter_fields(tree):
        if field in ("annotation", "returns", "decorator_list", "slice", "exc", "msg"):
            continue
        if field == "value" and isinstance(value, (ast.JoinedStr, ast.FormattedValue)):
            continue
        for index, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if not isinstance(child, ast.AST) or isinstance(child, ast.JoinedStr):
                continue
            if isinstance(child, ast.keyword) and child.arg in _DIMENSIONLESS_KEYWORDS:
                continue
            yield tree, field, index, scope
            inner = child.name if isinstance(child, ast.FunctionDef) and not scope else scope
            yield from list_places(child, inner)


def list_mutants(target):
    """Return all mutants of a file."""
    tree = ast.parse((ROOT / target.path).read_text(encoding="utf-8"))
    found = []
    for parent, field, index, scope in list_places(tree):
        if target.functions and scope not in target.functions:
            continue
        value = getattr(parent, field)
        node = value if index is None else value[index]
        for other in change_node(node):
            _put(parent, field, index, ast.copy_location(copy.deepcopy(other), node))
            source = ast.unparse(ast.fix_missing_locations(tree))
            _put(parent, field, index, node)
            label = f"{target.name}.{scope or '(module)'}: {ast.unparse(node)} -> {ast.unparse(other)}"
            found.append(Mutant(target, node.lineno, label, source))  # type: ignore[attr-defined]
    return found


def _put(parent, field, index, node):
    if index is None:
        setattr(parent, field, node)
    else:
        getattr(parent, field)[index] = node


def sample_mutants(targets, count, seed):
    """Return ``count`` mutants that are not known to be equivalent, the same number of each file while it has any."""
    rng = random.Random(seed)
    pools = []
    for target in targets:
        found = list_mutants(target)
        rng.shuffle(found)
        pools.append([mutant for mutant in found if mutant.label not in EQUIVALENT])
    chosen = []
    while len(chosen) < count and any(pools):
        for pool in pools:
            if pool and len(chosen) < count:
                chosen.append(pool.pop())
    return chosen


def list_chosen():
    """Return the mutants of ``tests/mutants.toml``. Raises LookupError if an expression or a test is not there any more."""
    found = []
    for path, row in tomllib.loads(CHOSEN.read_text(encoding="utf-8")).items():
        target, text = Target(path, tuple(row["tests"]), marks=QUICK_MARKS), (ROOT / path).read_text(encoding="utf-8")
        if missing := [name for name in row["tests"] if not (ROOT / name).exists()]:
            raise LookupError(f"{path}: {missing[0]}: no such test")
        for old, new, *reason in row["changes"]:
            if text.count(old) != 1:
                raise LookupError(f"{path}: {old!r} is there {text.count(old)} times")
            label = f"{target.name}: {old.strip()} -> {new.strip() or '(nothing)'}"
            line = text.partition(old)[0].count("\n") + 1
            found.append(Mutant(target, line, label, text.replace(old, new), *reason))
    return found


def write_table(mutants, alive):
    """Put the number of mutants of each package, and those that live, into docs/validation.md."""
    rows = ["| package | changes | found | not found |", "|---|---|---|---|"]
    for package in sorted({mutant.package for mutant in mutants}):
        own = [mutant for mutant in mutants if mutant.package == package]
        left = [mutant for mutant in own if mutant in alive]
        reasons = "; ".join(f"`{mutant.label}`: {mutant.reason or 'no test'}" for mutant in left)
        rows.append(f"| {package} | {len(own)} | {len(own) - len(left)} | {reasons.replace('|', chr(92) + '|')} |")
    text = PAGE.read_text(encoding="utf-8")
    head, mark, rest = text.partition("<!-- generated: mutants -->\n\n")
    PAGE.write_text(head + mark + "\n".join(rows) + "\n\n" + rest[rest.index("<!-- end -->") :], encoding="utf-8")


# One run.


class _Loader(SourceFileLoader):
    """Loads a module from another source; its file stays the same, because data lie beside it."""

    def __init__(self, name, path, source):
        super().__init__(name, path)
        self.source = source

    def get_data(self, path):
        """Return the source."""
        return self.source.encode()

    def path_stats(self, path):
        """Raise OSError: the bytecode on the disk is that of the unchanged file."""
        raise OSError


class _Replacement(importlib.abc.MetaPathFinder):
    """Import one module from another source."""

    def __init__(self, target, source):
        self.target, self.source = target, source

    def find_spec(self, name, path=None, target=None):
        """Return how the module is loaded."""
        if name != self.target.module:
            return None
        file = str(ROOT / self.target.path)
        return importlib.util.spec_from_file_location(name, file, loader=_Loader(name, file, self.source))


def prepare_parent():
    """Import what all children need, without any file that is changed."""
    for name in PACKAGES:
        importlib.import_module(name)


def keep_python():
    """Let kernels stay plain Python."""
    import numpy as np

    compiled = importlib.import_module("driftform.util.compiled")

    def keep(function):
        return function

    def borrow_as(dtype=None):
        number = np.dtype(np.float64 if dtype is None else dtype)

        def borrow(array, start, shape):
            size = math.prod(shape) * number.itemsize // array.itemsize
            view = array.reshape(-1)[start : start + size].view(number).reshape(shape)
            return view.view(np.recarray) if number.names else view

        return borrow

    for name in ("compiled", "allocating", "borrowing", "vectorized"):
        setattr(compiled, name, keep)
    compiled.borrow_as = borrow_as
    compiled.borrow = borrow_as()
    from driftform.motion.forces import fields

    # Kernels read n.gravity, which numba gives any record.
    for name in ("LAW", "NUMBERS"):
        setattr(fields, name, np.dtype((np.record, getattr(fields, name))))


def start(target, source, folder, number, limit):
    """Run the tests of a file in a child, with another source of it; return the child's process number."""
    log = folder / f"{number}.txt"
    pid = os.fork()
    if pid:
        return pid
    signal.setitimer(signal.ITIMER_PROF, limit)
    sys.dont_write_bytecode = True
    stream = os.open(log, os.O_WRONLY | os.O_CREAT)
    os.dup2(stream, 1)
    os.dup2(stream, 2)
    code = 3
    try:
        if target.marks is MARKS:
            keep_python()
        assert target.module not in sys.modules, f"{target.module} is imported before it is changed"
        if source is not None:
            sys.meta_path.insert(0, _Replacement(target, source))
        import pytest

        options = ("-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-W", "ignore", "-m", target.marks)
        code = int(pytest.main([*options, "--rootdir", str(ROOT), *target.tests]))
    finally:
        os._exit(code)


def run_all(jobs, processes, folder):
    """Generate the number of each job, its exit code, negative after a signal, and its CPU time (s), as they end."""
    waiting, running = list(enumerate(jobs)), {}
    while waiting or running:
        while waiting and len(running) < processes:
            number, (target, source, limit) = waiting.pop(0)
            running[start(target, source, folder, number, limit)] = number
        pid, status, used = os.wait4(-1, 0)
        yield running.pop(pid), os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime


def main():
    """Run mutants and print those that live."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", help="name of one file, without .py")
    parser.add_argument(
        "--chosen", action="store_true", help="the mutants of tests/mutants.toml, in place of drawn ones"
    )
    parser.add_argument("--count", type=int, default=60, help="mutants to draw, the same number of each file")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=1, choices=(1, 2))
    parser.add_argument("--list", action="store_true", help="print the mutants without running them")
    given = parser.parse_args()
    os.chdir(ROOT)
    if given.chosen:
        mutants = [mutant for mutant in list_chosen() if given.only in (None, mutant.target.name)]
        targets = list(dict.fromkeys(mutant.target for mutant in mutants))
    else:
        targets = [target for target in TARGETS if given.only in (None, target.name)]
        mutants = sample_mutants(targets, given.count, given.seed)
    if not mutants:
        parser.error(f"--only {given.only}: no such file")
    if given.list:
        print(*(f"{m.target.path}:{m.line} {m.label}" for m in mutants), sep="\n")
        return 0
    prepare_parent()
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        limits = {}
        for number, code, seconds in run_all([(target, None, LIMIT_S) for target in targets], given.processes, folder):
            limits[targets[number]] = max(LONGER * seconds, MIN_LIMIT_S)
            print(f"{time.monotonic() - begun:6.1f} s  {targets[number].name}: exit code {code} unchanged", flush=True)
            if code:
                print((folder / f"{number}.txt").read_text(encoding="utf-8"))
                return 2
        alive = []
        jobs = [(m.target, m.source, limits[m.target]) for m in mutants]
        for number, code, _ in run_all(jobs, given.processes, folder):
            mutant = mutants[number]
            word = {0: "LIVES", -signal.SIGPROF: "too slow"}.get(code, "killed")
            print(
                f"{time.monotonic() - begun:6.1f} s  {word:8} {mutant.target.path}:{mutant.line} {mutant.label}",
                flush=True,
            )
            if code == 0:
                alive.append(mutant)
    print(f"{len(alive)} of {len(mutants)} mutants live; {time.monotonic() - begun:.0f} s")
    for mutant in alive:
        print(f"  {mutant.target.path}:{mutant.line} {mutant.label}{mutant.reason and ': '}{mutant.reason}")
    if os.environ.get("UPDATE_DOCS") == "1" and given.chosen and not given.only:
        write_table(mutants, alive)
    return 0 if all(mutant.reason for mutant in alive) else 1


if __name__ == "__main__":
    sys.exit(main())
