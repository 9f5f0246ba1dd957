"""Change one operator or constant of a core formula at a time, and list the changes that no test finds.

    uv run python tests/mutations.py [--only NAME] [--count 60] [--seed 0]
    uv run python tests/mutations.py --chosen [--only NAME]

The first command draws changes of the files in ``tests/formulas.toml``. The second makes those of ``tests/mutants.toml``,
which reach all over the house; with UPDATE_DOCS=1 it writes their table in docs/validation.md.

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
FORMULAS, CHOSEN = (ROOT / "tests" / name for name in ("formulas.toml", "mutants.toml"))
PAGE = ROOT / "docs" / "validation.md"

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
    """A file, the tests that judge it, and the functions that count as formulas."""

    path: str
    tests: tuple[str, ...]
    functions: tuple[str, ...] = ()
    """Without any, the whole file."""
    equivalent: tuple[str, ...] = ()
    """Labels of mutants that no test can find."""
    marks: str = MARKS

    @property
    def name(self):
        """Name by which ``--only`` selects it."""
        return Path(self.path).stem

    @property
    def module(self):
        """Name of the module."""
        return ".".join(Path(self.path.rpartition("src/")[2]).with_suffix("").parts)


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


def list_targets():
    """Return the files of formulas."""
    rows = tomllib.loads(FORMULAS.read_text(encoding="utf-8")).items()
    return [
        Target(
            path, *(tuple(row.get(key, ())) for key in ("tests", "functions")), tuple(dict(row.get("equivalent", ())))
        )
        for path, row in rows
    ]


def sample_mutants(targets, count, seed):
    """Return ``count`` mutants that are not known to be equivalent, the same number of each file while it has any."""
    rng = random.Random(seed)
    pools = []
    for target in targets:
        found = list_mutants(target)
        rng.shuffle(found)
        pools.append([mutant for mutant in found if mutant.label not in target.equivalent])
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


def replace_source(target, source):
    """Import one module from another source; its file stays the same, because data lie beside it."""
    read = SourceFileLoader.get_code

    def get_code(loader, name):
        return compile(source, loader.path, "exec") if name == target.module else read(loader, name)

    SourceFileLoader.get_code = get_code  # type: ignore[method-assign]


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


def run(target, source, limit):
    """Run the tests of a file in a child, with another source of it if one is given.

    Return its exit code, negative after a signal, its CPU time (s) and what it printed.
    """
    with tempfile.TemporaryFile() as log:
        if not (child := os.fork()):
            code = 3
            try:
                signal.setitimer(signal.ITIMER_PROF, limit)
                sys.dont_write_bytecode = True
                for stream in (1, 2):
                    os.dup2(log.fileno(), stream)
                if target.marks is MARKS:
                    keep_python()
                assert target.module not in sys.modules, f"{target.module} is imported before it is changed"
                if source is not None:
                    replace_source(target, source)
                import pytest

                options = ("-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-W", "ignore", "-m", target.marks)
                code = int(pytest.main([*options, "--rootdir", str(ROOT), *target.tests]))
            finally:
                os._exit(code)
        _, status, used = os.wait4(child, 0)
        log.seek(0)
        return os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, log.read().decode(errors="replace")


def main():
    """Run mutants and print those that live."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--only", help="name of one file, without .py")
    parser.add_argument(
        "--chosen", action="store_true", help="the mutants of tests/mutants.toml, in place of drawn ones"
    )
    parser.add_argument("--count", type=int, default=60, help="mutants to draw, the same number of each file")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--list", action="store_true", help="print the mutants without running them")
    given = parser.parse_args()
    os.chdir(ROOT)
    if given.chosen:
        mutants = [mutant for mutant in list_chosen() if given.only in (None, mutant.target.name)]
        targets = list(dict.fromkeys(mutant.target for mutant in mutants))
    else:
        targets = [target for target in list_targets() if given.only in (None, target.name)]
        mutants = sample_mutants(targets, given.count, given.seed)
    if not mutants:
        parser.error(f"--only {given.only}: no such file")
    if given.list:
        print(*(f"{m.target.path}:{m.line} {m.label}" for m in mutants), sep="\n")
        return 0
    for name in PACKAGES:
        importlib.import_module(name)
    begun, limits, alive = time.monotonic(), {}, []
    for target in targets:
        code, seconds, printed = run(target, None, LIMIT_S)
        limits[target] = max(LONGER * seconds, MIN_LIMIT_S)
        print(f"{time.monotonic() - begun:6.1f} s  {target.name}: exit code {code} unchanged", flush=True)
        if code:
            print(printed)
            return 2
    for mutant in mutants:
        code, *_ = run(mutant.target, mutant.source, limits[mutant.target])
        word = {0: "LIVES", -signal.SIGPROF: "too slow"}.get(code, "killed")
        place = f"{mutant.target.path}:{mutant.line} {mutant.label}"
        print(f"{time.monotonic() - begun:6.1f} s  {word:8} {place}", flush=True)
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
