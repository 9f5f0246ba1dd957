"""A run.db that is not as driftform left it is refused in one line, to go on with and to read from."""

import json
import os
import shutil
import sqlite3
import struct
import zlib
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from driftform.runs.store import SCHEMA_VERSION


def overwritten(data):
    return lambda path: path.write_bytes(data) and None


def truncated(size):
    return lambda path: os.truncate(path, size)


def garbled(share):
    """Garbage over one page."""

    def harm(path):
        data = bytearray(path.read_bytes())
        start = int(share * len(data)) // 4096 * 4096
        data[start : start + 4096] = b"\xa5" * 4096
        path.write_bytes(data)

    return harm


def sql(*statements):
    def harm(path):
        connection = sqlite3.connect(path)
        for statement in statements:
            connection.execute(statement)
        connection.commit()
        connection.close()

    return harm


def flown(blob):
    """Another flight in place of every one."""

    def harm(path):
        with closing(sqlite3.connect(path)) as connection, connection:
            connection.execute("UPDATE evaluation SET trajectory = ?", (blob,))

    return harm


def flight_of(*rows, numbers=16383, count=None):
    """A flight as it is stored, of rows of 14 numbers; it says which are there, and how many rows."""
    planes = np.array(rows, dtype="<f4").T.copy().view(np.uint8).reshape(-1, 4).T.tobytes()
    header = struct.pack("<HII", numbers, len(rows) if count is None else count, zlib.adler32(planes))
    low = len(planes) // 4 * 3
    return header + planes[:low] + zlib.compress(planes[low:])


SOUND = flight_of([0.0] * 14, [1.0] * 14)


def studied(change):
    """Another study in place of that of the run."""

    def harm(path):
        with closing(sqlite3.connect(path)) as connection, connection:
            [text] = connection.execute("SELECT value FROM meta WHERE key = 'study'").fetchone()
            document = json.loads(text)
            change(document)
            connection.execute("UPDATE meta SET value = ?", (json.dumps(document),))

    return harm


ENDLESS = """CREATE VIEW {} AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)
SELECT i AS evaluation, 'TP1' AS target, 1.0 AS fitness FROM n"""


def foreign(path):
    path.unlink()
    sql("CREATE TABLE bookmarks (url)")(path)


DAMAGE = "is damaged"


@pytest.mark.parametrize(
    ("harm", "told"),
    [
        (overwritten(b""), "is empty or cut short: the run never began"),
        (truncated(50), "is empty or cut short"),
        (overwritten(b"\x80\x04\x95" * 5000), DAMAGE),
        (truncated(100_000), DAMAGE),
        (garbled(0.1), DAMAGE),
        (garbled(0.9), DAMAGE),
        (foreign, "is a database, but not of a driftform run"),
        (sql("PRAGMA user_version = 7"), f"is of format 7, this driftform reads format {SCHEMA_VERSION}"),
        (sql("PRAGMA user_version = 5"), "(of 0.1.0, git checkout 645490ca)"),
        (sql("DROP TABLE meta"), "meta"),
        (sql("ALTER TABLE evaluation DROP COLUMN seconds"), "evaluation"),
        (sql("ALTER TABLE evaluation RENAME COLUMN symbols TO letters"), "evaluation"),
        (sql("DELETE FROM meta"), DAMAGE),
        (sql("UPDATE meta SET value = '{'"), DAMAGE),
        (sql("UPDATE meta SET value = '{}'"), "no plugin is selected"),
        (sql("UPDATE evaluation SET symbols = '{'"), DAMAGE),
        (sql("UPDATE evaluation SET trajectory = x'0011'"), DAMAGE),
        (sql("UPDATE evaluation SET ended = 'x'"), DAMAGE),
        (sql("UPDATE score SET fitness = 'abc'"), DAMAGE),
        (sql("UPDATE evaluation SET symbols = '[1, 2]'"), DAMAGE),
        (sql("UPDATE evaluation SET grammar = 'other'"), "of the grammar 'other', expected 'lsystem'"),
        (flown(b""), "a flight is cut short"),
        (flown(SOUND[:-1]), "a flight has another length than it says"),
        (flown(SOUND[:20] + b"x" + SOUND[21:]), "a flight has other bytes than it says"),
        (flown(flight_of([0.0] * 14, count=1 << 31)), "a flight has another length than it says"),
        (flown(flight_of([0.0] * 14, numbers=0xFFFF)), "a flight has another length than it says"),
        (flown(flight_of([], numbers=0, count=1 << 31)), "a flight has another length than it says"),
        (flown(SOUND[:94] + zlib.compress(bytes(1 << 29), 9)), "a flight has another length than it says"),
        (flown(flight_of([0.0] * 14, [np.nan] * 14)), "a flight has numbers that are not finite"),
        (flown(flight_of([1.0] * 14, [0.5] * 14)), "the times of a flight decrease"),
        (studied(lambda study: study.update(targets={})), "targets"),
        (studied(lambda study: study.update(targets={"../x": [1.0, 0.0, 0.0]})), "names a folder"),
        (studied(lambda study: study["fluid"].update(density=np.nan)), "fluid.density = nan"),
        (sql("DROP TABLE score", ENDLESS.format("score")), "not as driftform makes them: score"),
        (sql(ENDLESS.format("more")), "not as driftform makes them: more"),
        (
            sql("CREATE TRIGGER t AFTER INSERT ON evaluation BEGIN DELETE FROM score; END"),
            "not as driftform makes them: t",
        ),
    ],
)
def test_to_resume_and_to_read(refused, run_copy, harm, told):
    harm(run_copy / "run.db")
    for args in (("resume", "run", "--workers", 1), ("inspect", "run:TP1")):
        line = refused(*args)
        assert line.startswith("error: run/run.db: ")
        assert told in line


def test_a_run_whose_exporter_is_no_longer_installed_is_read_and_not_resumed(call, refused, run_copy):
    studied(lambda study: study["run"].update(formats=["gone"]))(run_copy / "run.db")
    assert call("inspect", "run:TP1").exit_code == 0
    line = refused("resume", "run", "--workers", 1)
    assert line.startswith("error: run/run.db: ")
    assert "no exporter is named 'gone'" in line


@pytest.mark.parametrize(
    ("harm", "code", "line"),
    [
        (sql("DELETE FROM score WHERE evaluation = 3"), 2, "error: "),
        (sql("UPDATE evaluation SET trajectory = NULL"), 2, "error: "),
        (sql("""UPDATE evaluation SET symbols = '["C"]' WHERE id = 3"""), 2, "error: "),
        # Rows that do not fit those to be written.
        (sql("DELETE FROM evaluation WHERE id = 3"), 1, "error: run/run.db: evaluation "),
        (sql("UPDATE evaluation SET id = id + 100"), 1, "error: run/run.db: evaluation "),
    ],
)
def test_to_resume(run_copy, call, rows, harm, code, line):
    harm(run_copy / "run.db")
    before = rows(run_copy)
    result = call("resume", "run", "--workers", 1)
    assert isinstance(result.exception, SystemExit) and result.exit_code == code
    assert result.stderr.splitlines()[-1].startswith(line)
    assert code == 1 or rows(run_copy) == before


def test_a_directory_in_place_of_the_database(refused, run_copy):
    (run_copy / "run.db").unlink()
    (run_copy / "run.db").mkdir()
    assert refused("resume", "run").startswith("error: run holds no run.db")


def test_a_copy_whose_log_was_left_by_a_crash_is_whole(run_copy, call, tmp_path, rows):
    # What a process that was killed leaves: rows that only the write-ahead log has.
    connection = sqlite3.connect(run_copy / "run.db", isolation_level=None)
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA wal_autocheckpoint = 0")
    connection.execute("DELETE FROM score WHERE evaluation > 9")
    connection.execute("DELETE FROM evaluation WHERE id > 9")
    crashed = Path(shutil.copytree(run_copy, tmp_path / "crashed"))
    connection.close()
    assert (crashed / "run.db-wal").stat().st_size > 0
    assert call("resume", "crashed", "--workers", 1).exit_code == 0
    assert [row[0] for row in rows(crashed)[:20]] == list(range(20))
    assert [path.name for path in crashed.glob("run.db*")] == ["run.db"]


@pytest.mark.long
def test_a_locked_run_is_not_called_damaged_and_stays_as_it_is(run_copy, call, rows):
    before = rows(run_copy)
    with closing(sqlite3.connect(run_copy / "run.db")) as other:
        other.execute("BEGIN EXCLUSIVE")
        result = call("inspect", "run:TP1")
        other.rollback()
    assert result.exit_code == 1
    [line] = result.stderr.splitlines()
    assert line.startswith("error: run/run.db: cannot be read here: database is locked; the data are untouched")
    assert rows(run_copy) == before


@pytest.mark.parametrize("name", ["\x1b[2Jcleared", "line\nfeed"])
def test_a_name_that_steers_a_terminal_is_refused_before_it_is_shown(refused, run_copy, name):
    studied(lambda study: study.update(targets={name: [1.0, 0.0, 0.0]}))(run_copy / "run.db")
    for args in (("watch", "run", "--once"), ("watch", "run", "--json"), ("report", "run"), ("resume", "run")):
        assert f"a target is named {name!r}" in refused(*args)
