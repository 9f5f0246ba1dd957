"""A run on disk: every evaluation in one SQLite file, written as it comes, read back to resume.

The file holds data only: numbers, text, and trajectories as compressed float32 arrays. Opening one never runs code.
"""

import json
import re
import sqlite3
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from driftform.errors import InputError, WorkFailedError
from driftform.types import Candidate, End, Evaluation, Genome, Trajectory

APPLICATION_ID = 0x64726674
SCHEMA_VERSION = 2
SAMPLE_GAP = 0.01
"""Samples of a stored trajectory are at least this far apart, s."""

_SCHEMA = """
CREATE TABLE meta (
    key TEXT PRIMARY KEY,
    value TEXT NOT NULL
) WITHOUT ROWID;
CREATE TABLE evaluation (
    id INTEGER PRIMARY KEY,      -- index in the run, from 0
    generation INTEGER NOT NULL,
    population TEXT NOT NULL,    -- the target that its population works for
    parents TEXT NOT NULL,       -- JSON array of evaluation ids
    grammar TEXT NOT NULL,
    symbols TEXT NOT NULL,       -- JSON array of strings
    failure TEXT,
    ended TEXT,
    duration REAL,               -- of the flight, s
    contact REAL,                -- when it first touched a wall, s
    energy_drift REAL,           -- up to then, relative
    error REAL,                  -- estimated, of the position, m
    seconds REAL NOT NULL,       -- that the evaluation took
    trajectory BLOB              -- see encoded(): t, position, quaternion, velocity
);
CREATE TABLE score (
    evaluation INTEGER NOT NULL REFERENCES evaluation (id),
    target TEXT NOT NULL,
    fitness REAL NOT NULL,
    PRIMARY KEY (target, evaluation)
) WITHOUT ROWID;
"""


_COLUMNS = {
    table: tuple(re.findall(r"^    ([a-z_]+) ", body, re.MULTILINE))
    for table, body in re.findall(r"CREATE TABLE (\w+) \(\n(.*?)\n\)", _SCHEMA, re.DOTALL)
}
"""The columns of every table, as the schema has them."""

_HEADER = 100
"""Bytes that every SQLite file begins with."""

_NEXT_STEP = "restore a copy of it, or start a new run"


@dataclass(frozen=True, eq=False)
class Record:
    """One stored evaluation: its index in the run, what was asked, and the outcome."""

    index: int
    candidate: Candidate
    evaluation: Evaluation


class Store:
    """The open database of one run; one writer, any number of readers."""

    def __init__(self, connection: sqlite3.Connection, path: Path) -> None:
        self._connection = connection
        self._path = path

    @classmethod
    def create(cls, path: Path, study: Mapping[str, Any]) -> "Store":
        """Make a new run file for a study's document.

        Raises
        ------
        InputError
            where the file exists already.
        WorkFailedError
            where it cannot be written.
        """
        if path.exists():
            raise InputError(f"{path} exists already: resume that run, or choose another --out")
        connection = _connect(path)
        try:
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = FULL")
            with _transaction(connection):
                connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
                connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
                for statement in _SCHEMA.split(";\n"):
                    connection.execute(statement)
                connection.execute("INSERT INTO meta VALUES ('study', ?)", (json.dumps(study),))
        except sqlite3.Error as error:
            connection.close()
            raise WorkFailedError(f"{path}: cannot be written: {error}") from None
        return cls(connection, path)

    @classmethod
    def open(cls, path: Path) -> "Store":
        """Open the file of an earlier run, to read it or to go on with it.

        Raises
        ------
        InputError
            where there is none, or it is damaged or not a run of driftform.
        """
        if not path.is_file():
            raise InputError(f"{path}: no such file; a run directory holds one")
        if path.stat().st_size < _HEADER:
            raise InputError(
                f"{path}: is empty or cut short: the run never began, or its data is lost; {_NEXT_STEP}"
            )
        connection = _connect(path)
        try:
            application = connection.execute("PRAGMA application_id").fetchone()[0]
            version = connection.execute("PRAGMA user_version").fetchone()[0]
            sound = (
                application != APPLICATION_ID
                or connection.execute("PRAGMA quick_check").fetchone()[0] == "ok"
            )
            columns = {
                table: tuple(row[1] for row in connection.execute(f"PRAGMA table_info({table})"))
                for table in _COLUMNS
            }
        except sqlite3.DatabaseError as error:
            connection.close()
            raise InputError(f"{path}: is damaged ({error}); {_NEXT_STEP}") from None
        problem = ""
        if application != APPLICATION_ID:
            problem = "is a database, but not of a driftform run"
        elif version != SCHEMA_VERSION:
            problem = (
                f"is of format {version}, this driftform reads format {SCHEMA_VERSION}; use the driftform that "
                "environment.json names"
            )
        elif not sound:
            problem = f"is damaged; {_NEXT_STEP}"
        elif columns != _COLUMNS:
            broken = ", ".join(table for table in _COLUMNS if columns[table] != _COLUMNS[table])
            problem = f"is damaged (not as driftform makes them: {broken}); {_NEXT_STEP}"
        if problem:
            connection.close()
            raise InputError(f"{path}: {problem}")
        connection.execute("PRAGMA synchronous = FULL")
        return cls(connection, path)

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, and leave it whole without its write-ahead log where nobody else reads it."""
        try:
            self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._connection.execute("PRAGMA journal_mode = DELETE")
        except sqlite3.OperationalError:
            pass  # A reader holds the log, or the medium is read-only: the log stays, and nothing is lost.
        self._connection.close()

    def study(self) -> dict[str, Any]:
        """The document of the study that made the run."""
        with self._reading():
            row = self._connection.execute("SELECT value FROM meta WHERE key = 'study'").fetchone()
            document = json.loads(row[0])
            if not isinstance(document, dict):
                raise ValueError("the study is no table")
            return document

    def add(self, record: Record, targets: Sequence[str]) -> None:
        """Write one evaluation; when this returns it survives a crash."""
        candidate, evaluation = record.candidate, record.evaluation
        flight = evaluation.trajectory
        row = (
            record.index,
            candidate.generation,
            candidate.target,
            json.dumps(candidate.parents),
            candidate.genome.grammar,
            json.dumps(candidate.genome.symbols),
            evaluation.failure,
            str(flight.end) if flight else None,
            float(flight.t[-1]) if flight else None,
            *(_trust(flight).values() if flight else (None, None, None)),
            evaluation.seconds,
            encoded(flight) if flight else None,
        )
        scores = [(record.index, t, float(f)) for t, f in zip(targets, evaluation.fitness, strict=True)]
        try:
            with _transaction(self._connection):
                self._connection.execute(f"INSERT INTO evaluation VALUES ({','.join('?' * len(row))})", row)
                self._connection.executemany("INSERT INTO score VALUES (?, ?, ?)", scores)
        except sqlite3.Error as error:
            raise WorkFailedError(
                f"{self._path}: evaluation {record.index} cannot be written: {error}; what was written before is safe"
            ) from None

    def count(self) -> int:
        """How many evaluations there are."""
        return int(self._scalar("SELECT COUNT(*) FROM evaluation"))

    def failed(self) -> int:
        """How many of them failed."""
        return int(self._scalar("SELECT COUNT(*) FROM evaluation WHERE failure IS NOT NULL"))

    def records(self, targets: Sequence[str], first: int = 0, count: int = -1) -> Iterator[Record]:
        """Yield ``count`` evaluations from index ``first`` on, in their order; ``-1`` for all."""
        query = "SELECT * FROM evaluation WHERE id >= ? AND (? < 0 OR id < ? + ?) ORDER BY id"
        with self._reading(), closing(self._connection.execute(query, (first, count, first, count))) as rows:
            for row in rows:
                yield self._record(row, targets)

    def record(self, index: int, targets: Sequence[str]) -> Record:
        """Return one evaluation."""
        return next(self.records(targets, index, 1))

    def best(self, target: str) -> tuple[int, float] | None:
        """Index and fitness of the best evaluation for a target, the earliest of equals; ``None`` before any."""
        query = """
            SELECT evaluation, fitness FROM score JOIN evaluation ON id = evaluation
            WHERE target = ? AND failure IS NULL ORDER BY fitness DESC, evaluation LIMIT 1
        """
        with self._reading():
            row = self._connection.execute(query, (target,)).fetchone()
            return (int(row[0]), float(row[1])) if row else None

    def _scalar(self, query: str) -> Any:
        with self._reading():
            return self._connection.execute(query).fetchone()[0]

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """What cannot be read as it was written is damage, whatever it is that stumbles over it."""
        try:
            yield
        except (sqlite3.Error, zlib.error, ValueError, TypeError, KeyError, RecursionError) as error:
            told = f"{type(error).__name__}: {error}"
            raise InputError(f"{self._path}: is damaged ({told}); {_NEXT_STEP}") from None

    def _record(self, row: tuple[Any, ...], targets: Sequence[str]) -> Record:
        index, generation, population, parents, grammar, symbols, failure, ended, _, *trust, seconds, blob = (
            row
        )
        contact, drift, error = trust
        scores = dict(
            self._connection.execute(
                "SELECT target, fitness FROM score WHERE evaluation = ?", (index,)
            ).fetchall()
        )
        genome = Genome(grammar, tuple(json.loads(symbols)))
        evaluation = Evaluation(
            genome,
            np.array([scores[target] for target in targets]),
            decoded(blob, End(ended), contact=contact, energy_drift=drift, error=error)
            if blob is not None
            else None,
            failure,
            seconds,
        )
        return Record(
            index, Candidate(genome, tuple(json.loads(parents)), generation, population), evaluation
        )


def _connect(path: Path) -> sqlite3.Connection:
    try:
        return sqlite3.connect(path, isolation_level=None)
    except sqlite3.Error as error:
        raise WorkFailedError(f"{path}: cannot be opened: {error}") from None


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[None]:
    """All or nothing, also where it is interrupted."""
    connection.execute("BEGIN")
    with connection:
        yield


def compact(evaluation: Evaluation) -> Evaluation:
    """The evaluation as it reads back from the store: what a strategy is told, live or resumed."""
    flight = evaluation.trajectory
    if flight is None:
        return evaluation
    return replace(evaluation, trajectory=_flight(_columns(flight), flight.end, **_trust(flight)))


def _trust(flight: Trajectory) -> dict[str, float | None]:
    """What a trajectory tells of itself beside its samples."""
    return {"contact": flight.contact, "energy_drift": flight.energy_drift, "error": flight.error}


def encoded(trajectory: Trajectory) -> bytes:
    """Thin a trajectory to :data:`SAMPLE_GAP` and compress it as float32.

    Bytes of equal weight are put side by side, which zlib packs in a third of the time and to three quarters of the
    size.
    """
    return zlib.compress(_columns(trajectory).view(np.uint8).reshape(-1, 4).T.tobytes(), 1)


def decoded(blob: bytes, end: End, **trust: float | None) -> Trajectory:
    """Read what :func:`encoded` wrote; ``trust`` is what else the trajectory tells of itself, such as ``error``."""
    planes = np.frombuffer(zlib.decompress(blob), dtype=np.uint8).reshape(4, -1)
    return _flight(np.ascontiguousarray(planes.T).view("<f4").reshape(14, -1), end, **trust)


def _columns(trajectory: Trajectory) -> npt.NDArray[np.float32]:
    """What is kept of a trajectory: t, position, quaternion and velocity of some samples, (14, k)."""
    # Thinned by the rounded times: what is kept once is kept whole when it comes here again.
    kept = np.array(_thinned(trajectory.t.astype("<f4").tolist()))
    flown = (trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity)
    return np.column_stack([samples.take(kept, axis=0) for samples in flown]).T.astype("<f4", order="C")


def _flight(columns: npt.NDArray[np.float32], end: End, **trust: float | None) -> Trajectory:
    wide = columns.astype(np.float64)
    return Trajectory(wide[0], wide[1:4].T, wide[4:8].T, wide[8:14].T, end, **trust)


def _thinned(t: list[float]) -> list[int]:
    """Indices of samples at least the gap apart, among them the first and the last."""
    kept, latest = [0], t[0]
    for index, time in enumerate(t):
        if time - latest >= SAMPLE_GAP:
            kept.append(index)
            latest = time
    last = len(t) - 1
    if kept[-1] != last:
        if len(kept) > 1:
            kept.pop()
        kept.append(last)
    return kept
