"""What differs on clusters: other processes that compile, and processors that belong to others."""

import errno
import os
import subprocess
import sys

import pytest
from filelock import FileLock

from driftform.errors import InputError
from driftform.runs.directory import check_new, is_worked_on, lock_run
from driftform.util import cores, kernel_cache
from driftform.util.files import name_owner


def test_the_wait_for_another_process_that_compiles_ends_with_a_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(kernel_cache, "WAIT_S", 0.1)
    with FileLock(tmp_path / "k.lock"), kernel_cache.lock(tmp_path / "k.lock"):
        assert (
            capsys.readouterr().err
            == f"{tmp_path / 'k.lock'} was held by another process for 0.1 s; not waiting longer\n"
        )


@pytest.mark.skipif(sys.platform == "win32", reason="other locks")
@pytest.mark.parametrize("code", [errno.ENOLCK, errno.EOPNOTSUPP, errno.EIO])
def test_where_a_file_system_has_no_locks_a_file_names_who_holds_a_run(tmp_path, monkeypatch, code):
    import fcntl

    def refuse(file, operation):
        raise OSError(code, "no locks here")

    monkeypatch.setattr(fcntl, "flock", refuse)
    # A process that was killed leaves its file behind, and is not waited for.
    end = "import os, sys, filelock; lock = filelock.SoftFileLock(sys.argv[1]); lock.acquire(); os._exit(0)"
    owner = name_owner(tmp_path / ".lock")
    subprocess.run([sys.executable, "-c", end, str(owner)], check=True)
    assert owner.exists()
    with lock_run(tmp_path):
        assert is_worked_on(tmp_path)
        with pytest.raises(InputError, match="another driftform process"), lock_run(tmp_path):
            pass
    assert not is_worked_on(tmp_path)
    check_new(tmp_path)


@pytest.mark.parametrize(
    ("affinity", "quotas", "expected"),
    [(6, {}, 6), (1, {}, 1), (6, {"": "250000 100000"}, 3), (6, {"job/step": "max 100000", "job": "20000 100000"}, 1)],
)
def test_workers_are_as_many_as_affinity_and_control_groups_allow(tmp_path, monkeypatch, affinity, quotas, expected):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(affinity)))
    (tmp_path / "job" / "step").mkdir(parents=True)
    (tmp_path / "membership").write_text("0::/job/step\n")
    monkeypatch.setattr(cores, "_GROUPS", tmp_path)
    monkeypatch.setattr(cores, "_MEMBERSHIP", tmp_path / "membership")
    for folder, text in quotas.items():
        (tmp_path / folder / "cpu.max").write_text(text)
    assert cores.count_cores() == expected
