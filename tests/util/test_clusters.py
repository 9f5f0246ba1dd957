"""What differs on clusters: other processes that compile, and processors that belong to others."""

import os
from pathlib import Path

import pytest
from filelock import FileLock

from driftform.util import cores, kernel_cache


def test_the_wait_for_another_process_that_compiles_ends_with_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(kernel_cache, "WAIT_S", 0.1)
    with FileLock(tmp_path / "k.lock"), kernel_cache.lock(tmp_path / "k.lock"):
        assert (
            capsys.readouterr().err
            == f"{tmp_path / 'k.lock'} was held by another process for 0.1 s; not waiting longer\n"
        )


@pytest.mark.parametrize(
    ("affinity", "quotas", "expected"),
    [(6, {}, 6), (1, {}, 1), (6, {"": "250000 100000"}, 3), (6, {"job/step": "max 100000", "job": "20000 100000"}, 1)],
)
def test_workers_are_as_many_as_affinity_and_control_groups_allow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, affinity: int, quotas: dict[str, str], expected: int
) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(affinity)))
    (tmp_path / "job" / "step").mkdir(parents=True)
    (tmp_path / "membership").write_text("0::/job/step\n")
    monkeypatch.setattr(cores, "_GROUPS", tmp_path)
    monkeypatch.setattr(cores, "_MEMBERSHIP", tmp_path / "membership")
    for folder, text in quotas.items():
        (tmp_path / folder / "cpu.max").write_text(text)
    assert cores.count_cores() == expected
