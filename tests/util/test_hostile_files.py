"""Files from anybody: each ends with an answer or one line and exit code 2, and takes little time and memory."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytestmark = [pytest.mark.peers, pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")]


def write_bomb_netcdf(folder):
    """Velocities at four million nodes, all of them zero."""
    import netCDF4

    with netCDF4.Dataset(folder / "bomb.nc", "w") as file:
        for name in "xyz":
            file.createDimension(name, 160)
            file.createVariable(name, "f8", (name,))[:] = np.linspace(0, 9, 160)
        for name in "uvw":
            file.createVariable(name, "f8", tuple("xyz"), zlib=True)
    return write_study(folder, "bomb.nc")


def write_text_vtu(folder):
    (folder / "bomb.vtu").write_text("<VTKFile>" + 4_000_000 * "<a/>" + "</VTKFile>", encoding="utf-8")
    return write_study(folder, "bomb.vtu")


def write_study(folder, grid):
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


@pytest.mark.parametrize("write", [write_bomb_netcdf, write_text_vtu])
def test_a_bomb_is_one_line_and_takes_less_than_ten_seconds_and_500_mb(tmp_path, write):
    command = [Path(sys.executable).with_name("driftform"), *write(tmp_path)]
    measured = [sys.executable, "-c", MEASURE, *command]
    done = subprocess.run(measured, cwd=tmp_path, capture_output=True, text=True, check=False)
    code, seconds, largest = json.loads(done.stdout)
    assert code == 2 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1
    assert seconds < 10
    assert largest < 500e3, "kB of the largest of its processes"
