"""Odd surroundings, in which a command gives the same files as in usual ones, and a run the same rows.

``uv run pytest -m slow -s tests/endurance/test_surroundings.py``
"""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="closes descriptors, and sets limits of POSIX"),
]


def limit(name, value):
    import resource

    return lambda: resource.setrlimit(getattr(resource, name), (value, value))


def close(*descriptors):
    def close_all():
        for number in descriptors:
            os.close(number)

    return close_all


def set_all(**variables):
    """Return surroundings in which one variable of the environment has a value."""
    return {f"{name}={value}": {"env": {name: value}} for name, values in variables.items() for value in values}


SURROUNDINGS = {
    **set_all(
        LC_ALL=["C", "POSIX", "tr_TR.UTF-8", "zh_CN.GBK", "nonsense"],
        PYTHONIOENCODING=["ascii", "utf-16", "cp1252"],
        PYTHONUTF8=["0", "1"],
        TZ=["Pacific/Kiritimati", "nonsense", ""],
        COLUMNS=["1", "0", "x", "99999"],
        TERM=["dumb", "", "nonsense"],
        NO_COLOR=["1"],
        FORCE_COLOR=["1"],
        CI=["1"],
        PYTHONSAFEPATH=["1"],
        PYTHONDEVMODE=["1"],
        PYTHONOPTIMIZE=["2"],
        PYTHONHASHSEED=["7"],
        PYTHONDONTWRITEBYTECODE=["1"],
        OMP_NUM_THREADS=["1", "64"],
        PATH=[""],
        TMPDIR=["/nowhere"],
        HOME=["", "/dev/null/home"],
        XDG_CACHE_HOME=["/proc/nowhere"],
    ),
    "no environment": {"env": None},
    "no stdin": {"preexec_fn": close(0)},
    "no stdout": {"preexec_fn": close(1)},
    "no stderr": {"preexec_fn": close(2)},
    "none of them": {"preexec_fn": close(0, 1, 2)},
    "umask 077": {"preexec_fn": lambda: os.umask(0o77) and None},
    "nice 19": {"preexec_fn": lambda: os.nice(19) and None},
    "64 descriptors": {"preexec_fn": limit("RLIMIT_NOFILE", 64)},
    "20 descriptors": {"preexec_fn": limit("RLIMIT_NOFILE", 20)},
    "no core": {"preexec_fn": limit("RLIMIT_CORE", 0)},
    "stack of 1 MB": {"preexec_fn": limit("RLIMIT_STACK", 1 << 20)},
    "modules of the same names in the folder": {"files": ["numpy.py", "typer.py", "driftform.py", "json.py"]},
    "a folder with an odd name": {"folder": "a b\n'c\" %s {x} \u00e9\U0001f41f"},
    "a folder with a long name": {"folder": "n" * 250},
    "a folder of bytes that are no UTF-8": {"folder": os.fsdecode(b"\xff\xfe")},
}


NOBODY, OTHER_USER = 65534, "a clone of another user"


def become_nobody():
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)


def find_other_user():
    """Return surroundings in which the clone belongs to another user, if root runs the tests, by a Python for all."""
    try:
        subprocess.run([PROGRAM, "--version"], preexec_fn=become_nobody, capture_output=True, check=True)
    except (OSError, subprocess.SubprocessError):
        return {}
    return {OTHER_USER: {"preexec_fn": become_nobody, "env": {"HOME": ".", "NUMBA_CACHE_DIR": "cache"}}}


CLOCK_AND_PROCESSES = {
    "a clock that runs backward": {"site": "import time; t = time.time; b = t(); time.time = lambda: 2 * b - t()"},
    "processes that are forked": {"site": "import multiprocessing as m; m.set_start_method('fork')"},
}
"""With what Python runs before the program."""

RUN = ("LC_ALL=C", "LC_ALL=tr_TR.UTF-8", "PYTHONOPTIMIZE=2", "TZ=nonsense", "umask 077", "64 descriptors")

COMMANDS = {
    "sample --scenario paper --count 2": ("agents", SURROUNDINGS),
    "evolve paper --simulator native --target TP3 --evaluations 24 --workers 2": (
        "rows",
        CLOCK_AND_PROCESSES | {name: SURROUNDINGS[name] for name in RUN},
    ),
}


PROGRAM = str(Path(sysconfig.get_path("scripts")) / "driftform")


@pytest.mark.parametrize("words", COMMANDS)
def test_odd_surroundings_change_nothing(tmp_path, rows, show_row, words):
    command = [PROGRAM, *words.split(), "--seed", "3", "--out", "out"]
    what, surroundings = COMMANDS[words]
    surroundings = {**surroundings, **find_other_user()}
    fell, expected = [], None
    for number, (name, odd) in enumerate({"usual": {}, **surroundings}.items()):
        folder = tmp_path / str(number) / odd.get("folder", "here")
        folder.mkdir(parents=True)
        if name == OTHER_USER:
            os.chown(folder, NOBODY, NOBODY)
            for above in (folder.parent, tmp_path, *tmp_path.parents[:2]):
                above.chmod(0o711)
        for file in odd.get("files", ()):
            (folder / file).write_text("raise SystemExit('the wrong module')\n", encoding="utf-8")
        changed = odd.get("env", {})
        if "site" in odd:
            (folder / "sitecustomize.py").write_text(odd["site"], encoding="utf-8")
            changed = {"PYTHONPATH": str(folder)}
        environment = {} if changed is None else os.environ | changed
        done = subprocess.run(
            command, cwd=folder, env=environment, preexec_fn=odd.get("preexec_fn"), capture_output=True, check=False
        )
        is_run = (folder / "out" / "run.db").exists()
        found = rows(folder / "out") if is_run else {path.name: path.read_bytes() for path in folder.glob("out/*")}
        expected = expected or found
        if done.returncode or b"Traceback" in done.stderr or found != expected or len(found) < 2:
            fell.append((name, done.returncode, done.stderr[-500:]))
    assert not fell
    show_row("trials", f"odd surroundings of `{words.split(maxsplit=1)[0]}`", len(surroundings), f"the same {what}")


def test_of_two_runs_in_one_directory_one_is_refused_in_one_line(tmp_path, rows, show_row):
    words = ["evolve", "paper", "--simulator", "native", "--target", "TP3", "--evaluations", "24", "--workers", "1"]
    for number in range(5):
        command = [PROGRAM, *words, "--seed", "3", "--out", f"run-{number}"]
        both = [subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) for _ in range(2)]
        said = [process.communicate()[1].splitlines() for process in both]
        assert sorted(process.returncode for process in both) == [0, 2]
        [error] = [line for lines in said for line in lines if line.startswith("error: ")]
        assert f"run-{number}" in error
        # Each flight with its score.
        assert len(rows(tmp_path / f"run-{number}")) == 2 * 24
    show_row("trials", "two runs begun in one directory", 5, "one is refused in one line")
