"""Files from anybody: each ends with an answer or one line and exit code 2, and takes little time and memory."""

import json
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from driftform.water.parts.grid_files import read_grid

pytestmark = [pytest.mark.peers, pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")]

MODEL = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


def write_bomb_3mf(folder: Path) -> list[str]:
    """25 million elements in 100 kB."""
    with zipfile.ZipFile(folder / "bomb.3mf", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("_rels/.rels", f'<R><Relationship Target="/m.model" Id="r" Type="{MODEL}"/></R>')
        archive.writestr("m.model", "<model>" + 25_000_000 * "<a/>" + "</model>")
    return ["check", "bomb.3mf"]


def write_bomb_netcdf(folder: Path) -> list[str]:
    """Velocities at four million nodes, all of them zero."""
    import h5py

    with h5py.File(folder / "bomb.nc", "w") as file:
        for name in "xyz":
            file[name] = np.linspace(0, 9, 160)
        for name in "uvw":
            file.create_dataset(name, (160, 160, 160), "f8", compression="gzip")
            for axis in range(3):
                file[name].dims[axis].attach_scale(file["xyz"[axis]])
    return write_study(folder, "bomb.nc")


def write_text_vtu(folder: Path) -> list[str]:
    (folder / "bomb.vtu").write_text("<VTKFile>" + 4_000_000 * "<a/>" + "</VTKFile>", encoding="utf-8")
    return write_study(folder, "bomb.vtu")


def write_study(folder: Path, grid: str) -> list[str]:
    text = f'base = "paper"\n[flow]\nkind = "grid"\nfile = "{grid}"\n'
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return ["scenarios", "check", "study.toml"]


# The largest size of a process counts that of the process which starts it: a small one, and not the tests.
MEASURE = """
import json, os, subprocess, sys
process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL)
_, status, used = os.wait4(process.pid, 0)
print(json.dumps([os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss]))
"""


@pytest.mark.parametrize("write", [write_bomb_3mf, write_bomb_netcdf, write_text_vtu])
def test_a_bomb_is_one_line_and_takes_less_than_ten_seconds_and_500_mb(tmp_path: Path, write) -> None:
    command = [Path(sys.executable).with_name("driftform"), *write(tmp_path)]
    measured = [sys.executable, "-c", MEASURE, *command]
    done = subprocess.run(measured, cwd=tmp_path, capture_output=True, text=True, check=False)
    code, seconds, largest = json.loads(done.stdout)
    assert code == 2 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1
    assert seconds < 10
    assert largest < 500e3, "kB of the largest of its processes"


@pytest.mark.parametrize("count", [10, pytest.param(260, marks=pytest.mark.slow)])
def test_a_netcdf_file_with_wrong_bytes_is_read_or_refused_in_one_line(tmp_path: Path, count: int) -> None:
    import h5py

    path = tmp_path / "current.nc"
    rng = np.random.default_rng(3)
    with h5py.File(path, "w") as file:
        for name in "xyz":
            file[name] = np.linspace(0, 9, 6)
            file[name].make_scale(name)
        for name in "uvw":
            file.create_dataset(name, data=rng.normal(size=(6, 6, 6)), compression="gzip", chunks=(3, 3, 3))
            for axis in range(3):
                file[name].dims[axis].attach_scale(file["xyz"[axis]])
    assert read_grid(path).shape == (6, 6, 6)
    whole, refused = path.read_bytes(), 0
    for _ in range(count):
        content = bytearray(whole)
        for place in rng.integers(0, len(whole), rng.integers(1, 6)):
            content[place] = rng.integers(256)
        path.write_bytes(content)
        try:
            read_grid(path)
        except ValueError as error:
            refused += 1
            assert "\n" not in str(error)
    assert refused >= count // 15
