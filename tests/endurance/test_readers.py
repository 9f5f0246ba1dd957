"""Every reader of files from anybody, given changed files of our own making: an answer, or an error of one line.

``SECONDS=20 uv run pytest -m slow tests/endurance/test_readers.py`` shortens it. Each file is read in a process that is
forked for it, so that time, memory and crashes are seen. What :func:`driftform.util.foreign.call_apart` would call in a
process with limits is called directly: its crashes and its limits are an error of one line there (tests/util/test_foreign.py),
and only what follows is judged here.
"""

import os
import resource
import signal
import sys
import time
import traceback
from collections import Counter
from pathlib import Path
from warnings import catch_warnings

import numpy as np
import pytest
from grids import make_data_set, table_of, write_csv, write_netcdf3, write_netcdf4, write_vtk
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st
from prints import CORNERS, TRIANGLES, edit_archive, mesh_xml, write_3mf

from driftform import open_agent, open_run
from driftform.errors import DriftformError
from driftform.runs.agent_file import StoredAgent
from driftform.study import load_study
from driftform.util import foreign
from driftform.water.parts.grid_files import VelocityGrid, read_grid

pytestmark = [
    pytest.mark.slow,
    pytest.mark.peers,
    pytest.mark.skipif(sys.platform != "linux", reason="forks, and reads what a child used"),
]

MAX_S, MAX_MB = 10.0, 500.0

TOKENS = [
    *(b"", b"\0", b"\xff", b"\n", b"\r", b'"', b"'", b",", b";", b"\t", b"#", b"[", b"]", b"{", b"}", b"<", b">"),
    *(b"nan", b"inf", b"-1", b"0", b"1e999", b"-1e-999", b"9" * 30, b"9" * 5000, b"1" * 200_000, b"[" * 5000),
    *(b"\xef\xbb\xbf", b"\xff\xfe", b"true", b"null", b"\\u0000", b"\xf0\x9f\x90\x9f", b"../../x", b"\x7f\xff\xff\xff"),
]
"""What is put into a file."""

changes = st.lists(
    st.tuples(
        st.sampled_from(["put", "replace", "cut", "repeat", "flip", "end", "line"]),
        st.floats(0, 1, exclude_max=True),
        st.floats(0, 1),
        st.one_of(st.sampled_from(TOKENS), st.binary(max_size=8)),
    ),
    min_size=1,
    max_size=6,
)


def apply(whole, done):
    """Return a file with some changes."""
    for kind, place, extent, token in done:
        at = int(place * len(whole))
        after = at + 1 + int(extent**4 * 200)
        if kind in ("put", "replace"):
            whole = whole[:at] + token + whole[at if kind == "put" else at + len(token) :]
        elif kind == "cut":
            whole = whole[:at] + whole[after:]
        elif kind == "repeat":
            whole = whole[:after] + whole[at:after] * int(1 + 20 * extent) + whole[after:]
        elif kind == "flip" and whole:
            whole = whole[:at] + bytes([whole[at] ^ 1 << int(7 * extent)]) + whole[at + 1 :]
        elif kind == "end":
            whole = whole[:at]
        elif kind == "line":
            lines = whole.split(b"\n")
            lines.insert(int(extent * len(lines)), lines.pop(int(place * len(lines))))
            whole = b"\n".join(lines)
    return whole


CORPUS = Path(__file__).with_name("corpus")
"""Sound files of users."""

MOVED = (
    f'<object id="1">{mesh_xml()}</object><object id="2"><components>'
    '<component objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></components></object>'
)


def written(write, path, *arguments):
    """Return what a function writes to a file."""
    write(path, *arguments)
    return [path.read_bytes()]


def write_stored_3mf(path):
    write_3mf(path, MOVED, '<item objectid="2"/>')
    # Stored as they are: a changed byte then reaches the XML, and not only the check of the archive.
    edit_archive(path)


def make_grid():
    velocity = np.zeros((4, 4, 4, 3))
    velocity[..., 0] = np.indices((4, 4, 4)).sum(axis=0)
    return VelocityGrid(np.zeros(3), np.ones(3), velocity)


def write_grid(path, mode):
    return written(write_vtk, path, make_data_set(make_grid(), "vtu"), mode)


def make_mesh(kind, **options):
    import trimesh

    # GLB is in metres, the others are in millimetres.
    mesh = trimesh.Trimesh(CORNERS / (1000 if kind == "glb" else 1), TRIANGLES)
    content = mesh.export(file_type=kind, **options)
    return [content.encode() if isinstance(content, str) else bytes(content)]


def make_step(folder):
    # The sealed hull, although its flights are those of a kit.
    with pytest.warns(UserWarning, match="kit"):
        [file] = open_agent("C").export("step", folder / "made.step")
    return file.read_bytes()


def make_agent(folder):
    study = load_study("paper", run={"seed": 1})
    genome = study.make_plugin("grammar").random(np.random.default_rng(1))
    environment = {key: study.document[key] for key in study.document if key not in ("run", "strategy")}
    StoredAgent("one", genome, environment, {"target": "TP1", "fitness": 99.5}).write(folder / "made.json")
    return (folder / "made.json").read_bytes()


def make_run(folder):
    from driftform import evolve

    run = evolve(load_study("paper", run={"seed": 1, "evaluations": 6}), folder / "run", progress=False)
    return (run.path / "run.db").read_bytes()


def read_run(path):
    folder = path.parent / "read"
    folder.mkdir(exist_ok=True)
    path.replace(folder / "run.db")
    run = open_run(folder)
    with run.read() as store:
        targets = run.study.scenario.target_names
        list(store.read_records(targets))
        list(store.read_summaries(targets))
        list(store.read_trajectories())
        store.find_best(targets[0])


def read_track(path):
    from driftform_calibration.tables import read_table

    read_table(path)


def read_own_body(path):
    from driftform_frusta.own.profile import read_profile

    read_profile(path)


def read_printable(path):
    from driftform_kit.reading import read_meshes

    read_meshes(path)


def read_both(path):
    for read in (read_printable, read_own_body):
        try:
            read(path)
        except DriftformError as error:
            check_line(error)


def read_network(path):
    from driftform_networks.hydraulics.epanet import open_network

    open_network(path, path.parent / "cache")


def read_word(path):
    open_agent(path.read_text(encoding="utf-8", errors="surrogateescape"))


READERS = {
    "study": ("study.toml", lambda _: [(CORPUS / "study.toml").read_bytes()], load_study),
    "agent": ("agent.json", lambda f: [make_agent(f)], open_agent),
    "genome": ("word", lambda _: [b"addB-tiltn-1-M-moveB-addB-tiltp-1-L-moveB", b"C"], read_word),
    "track": ("track.csv", lambda _: [path.read_bytes() for path in sorted(CORPUS.glob("*.track"))], read_track),
    "profile": ("body.csv", lambda _: [b"x_mm,r_mm\n0,5\n20,30\n150,8\n", b"x_m;r_m\n0;0\n0,2;0,03\n"], read_own_body),
    "network": ("town.inp", lambda _: [(CORPUS / "town.inp").read_bytes()], read_network),
    "CSV grid": ("grid.csv", lambda f: written(write_csv, f / "made.csv", table_of(make_grid())), read_grid),
    "VTK": ("grid.vtk", lambda f: write_grid(f / "made.vtk", "Version 3.0"), read_grid),
    "VTU": ("grid.vtu", lambda f: write_grid(f / "made.vtu", "Appended"), read_grid),
    "NetCDF-3": ("grid.nc", lambda f: written(write_netcdf3, f / "made.nc", make_grid()), read_grid),
    "NetCDF-4": ("grid.nc", lambda f: written(write_netcdf4, f / "made.nc", make_grid()), read_grid),
    "3MF": ("part.3mf", lambda f: written(write_stored_3mf, f / "made.3mf"), read_printable),
    "STL": ("part.stl", lambda _: make_mesh("stl"), read_both),
    "OBJ": ("part.obj", lambda _: make_mesh("obj"), read_both),
    "PLY": ("part.ply", lambda _: make_mesh("ply", encoding="ascii"), read_both),
    "GLB": ("part.glb", lambda _: make_mesh("glb"), read_both),
    "STEP": ("part.step", lambda f: [make_step(f)], read_own_body),
    "run": ("run.db", lambda f: [make_run(f)], read_run),
}
"""Of each reader the name of its file, sound files, and what reads them."""


def check_line(error):
    """Check that an error says something; the program escapes what would not be one line of it."""
    assert error.args and all(map(str, error.args)), repr(error)
    assert isinstance(error, DriftformError) or "\n" not in str(error), repr(error)


def call_here(function, *arguments, **_):
    """Call what ``call_apart`` calls, and translate its errors as that does; a signal ends the child as "refused"."""
    os.write(PIPE[0], b"(")
    try:
        return function(*(str(a.absolute()) if isinstance(a, Path) else a for a in arguments))
    except (DriftformError, ValueError):
        raise
    except BaseException as error:
        raise ValueError(f"cannot be read: {error!r}"[:200].replace("\n", " ")) from None
    finally:
        os.write(PIPE[0], b")")


PIPE = [0]


def read_apart(read, path):
    """Read a file in a forked process; return what became of it, "read" or "refused".

    Raises AssertionError for anything else, with the traceback.
    """
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    ours, PIPE[0] = os.pipe()
    with catch_warnings(action="ignore"):
        child = os.fork()
    if not child:
        status = 1
        try:
            os.close(ours)
            signal.signal(signal.SIGXCPU, signal.SIG_DFL)
            resource.setrlimit(resource.RLIMIT_CPU, (int(MAX_S), int(MAX_S) + 1))
            foreign.call_apart = call_here
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, 1)
            os.dup2(null, 2)
            with catch_warnings(action="ignore"):
                try:
                    read(path)
                    status = 0
                except DriftformError as error:
                    check_line(error)
                    status = 3
                except ValueError as error:
                    # A reader of grids has no name of the file; whoever calls it adds that.
                    assert read is read_grid, error
                    check_line(error)
                    status = 3
        except BaseException:
            os.write(PIPE[0], traceback.format_exc()[-3000:].encode(errors="replace"))
        finally:
            os._exit(status)
    os.close(PIPE[0])
    with os.fdopen(ours, "rb") as file:
        said = file.read().decode(errors="replace")
    _, status, used = os.wait4(child, 0)
    code = os.waitstatus_to_exitcode(status)
    if code < 0 and said.count("(") > said.count(")"):
        return "refused"
    assert code in (0, 3), f"exit code {code}: {said}"
    assert used.ru_utime + used.ru_stime < MAX_S
    assert (used.ru_maxrss - before) / 1e3 < MAX_MB
    return "read" if code == 0 else "refused"


@pytest.mark.parametrize("name", READERS)
def test_a_changed_file_is_read_or_refused_in_one_line(name, tmp_path, count_of, show_row):
    file, make, read = READERS[name]
    corpus, found = make(tmp_path), Counter[str]()
    end, path = time.monotonic() + count_of("SECONDS", 60), tmp_path / "given" / file
    path.parent.mkdir()
    for whole in corpus:
        path.write_bytes(whole)
        assert read_apart(read, path) == "read", "a sound file"

    def check(whole, done):
        if time.monotonic() < end:
            path.write_bytes(apply(whole, done))
            found[read_apart(read, path)] += 1

    number = 0
    while time.monotonic() < end:
        # In rounds, each from its own seed: a round ends in good time, and a failure is shrunk and repeats.
        number += 1
        run = given(st.sampled_from(corpus), changes)(check)
        quiet = settings(max_examples=100, deadline=None, database=None, suppress_health_check=list(HealthCheck))
        seed(number)(quiet(run))()
    told = f"{found['read']} read, {found['refused']} refused in one line"
    print(f"{name}: {told}")
    if name in ("study", "agent", "run"):
        show_row("trials", f"an altered {name}", found.total(), told)
    assert found.total(), "no time"
