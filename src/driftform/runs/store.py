"""A run on disk: every evaluation in one SQLite file, written as it comes, read back to resume.

The file holds data only: numbers, text, and trajectories as compressed float32 arrays. Opening one never runs code.
"""

import json
import re
import sqlite3
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error, find_commonest
from driftform.runs.compression import MAX_FLIGHT_BYTES, compress, decode, diagnostics
from driftform.runs.directory import resume_command
from driftform.types import Candidate, End, Evaluation, FloatArray, Genome, Trajectory
from driftform.util.files import identify_file, write_whole

APPLICATION_ID = 0x64726674
"""In the header of a file of SQLite: by it a database is known as one of ours."""

SCHEMA_VERSION = 6
"""Of the tables; a database of another version is refused."""

_LAST_COMMITS = {
    number: f" (of 0.1.0, git checkout {commit})"
    for number, commit in enumerate(("44258085", "9387da45", "030f1d0f", "b859660b", "645490ca"), start=1)
}
"""What to say of a database of an earlier version: the last commit that reads it."""

_SCHEMA = Path(__file__).with_name("schema.sql").read_text(encoding="utf-8")

MAX_INDEX = 2**62
"""Larger than the index of any evaluation."""


def _normalise(statement: str) -> str:
    """Return a statement without comments and without what only lays it out."""
    return " ".join(re.sub(r"--[^\n]*", "", statement).split())


_TABLES = {statement.split()[2]: _normalise(statement) for statement in _SCHEMA.split(";\n") if statement.strip()}
"""The statement that made each table."""

_HEADER = 100
"""Bytes that every SQLite file begins with."""

_MAX_ROW_BYTES = MAX_FLIGHT_BYTES + (1 << 20)
"""Largest row that is written or read, bytes: SQLite refuses a larger one before it takes memory."""

_DAMAGE = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
"""Errors of SQLite that mean damage; all others are about the place: a full disk, a lock, a right that is missing."""

_SCORE = ", (SELECT fitness FROM score WHERE target = ? AND evaluation = id)"
"""A column of the fitness for a target."""

_INSERT = f"INSERT INTO evaluation VALUES ({','.join('?' * 16)})"

_NEXT_STEP = "restore a copy of it, or start a new run"


@dataclass(frozen=True, eq=False)
class Record:
    """One stored evaluation: its index in the run, its candidate as the strategy asked for it, its outcome, and the seed of its gusts."""

    index: int
    candidate: Candidate
    evaluation: Evaluation
    seed: int = 0

    @property
    def summary(self) -> "EvaluationSummary":
        """The same without genome and flight."""
        one, of = self.evaluation, self.candidate
        values = (one.failure, tuple(one.fitness.tolist()), one.measures, one.violations)
        return EvaluationSummary(self.index, of.generation, of.target, *values)


@dataclass(frozen=True)
class EvaluationSummary:
    """A stored evaluation without its genome and flight.

    ``population`` is the target that its population works for, ``""`` for all; ``failure`` says why it has no flight that counts;
    ``measures`` and ``violations`` are those of the :class:`~driftform.types.Evaluation`.
    """

    index: int
    generation: int
    population: str
    failure: str | None
    fitness: Sequence[float]
    measures: Mapping[str, float] = field(default_factory=dict)
    violations: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class DisturbedResult:
    """The result of one flight of an evaluation's agent under a disturbed condition.

    Attributes:
        evaluation: index of the evaluation.
        condition: number of the condition, from 0.
        fitness: for each target, %, (targets,).
        offsets: vector from each target to the closest approach, world frame, m, (targets, 3); NaN for a failed
            flight, and where the flight was not for the target.
        failure: what went wrong, ``None`` for nothing.
    """

    evaluation: int
    condition: int
    fitness: FloatArray
    offsets: FloatArray
    failure: str | None = None


class Store:
    """The open database of one run; one writer, any number of readers."""

    def __init__(self, connection: sqlite3.Connection, path: Path, read_only: bool = False) -> None:
        self._connection, self._path, self._read_only, self._place = connection, path, read_only, identify_file(path)

    @classmethod
    def create(cls, path: Path, study: Mapping[str, Any]) -> "Store":
        """Make a new run file for a study's document.

        Raises InputError if the file exists already, WorkFailedError if it cannot be written.
        """
        if path.exists():
            raise InputError(f"{path} exists already: resume that run, or choose another --out")
        try:
            # In place in one step: a killed process leaves no partial file.
            write_whole(path, lambda part: _write_empty(part, study))
            connection = _connect(path)
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = FULL")
        except (sqlite3.Error, OSError) as error:
            raise WorkFailedError(f"{path}: {_describe_unwritten(error, path)}") from None
        return cls(connection, path)

    @classmethod
    def open(cls, path: Path, *, read_only: bool = False, check: bool = True) -> "Store":
        """Open the file of an earlier run, to continue it or to read it.

        With ``read_only`` the file and its log are left as they are, and a writer is neither held up nor disturbed.
        Without ``check`` the pages are not checked first, which takes time: damage is reported where it is read. Raises
        InputError if it is missing, damaged, or not a run of driftform.
        """
        if not path.is_file():
            raise InputError(f"{path}: no such file; a run directory holds one")
        if path.stat().st_size < _HEADER:
            raise InputError(f"{path}: is empty or cut short: the run never began, or its data is lost; {_NEXT_STEP}")
        connection = _connect(path, read_only)
        try:
            application, version = (_ask(connection, f"PRAGMA {name}") for name in ("application_id", "user_version"))
            sound = not check or application != APPLICATION_ID or _ask(connection, "PRAGMA quick_check") == "ok"
            # What is missing or not as it is made, and whatever could act in its place.
            rows = connection.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
            made = {name: _normalise(str(sql)) for kind, name, sql in rows if kind == "table"}
            # Runs of 0.2.0 have no measures.
            made.setdefault("measured", _TABLES["measured"])
            broken = [table for table in _TABLES if made.get(table) != _TABLES[table]]
            broken += [str(name) for kind, name, _ in rows if kind in ("view", "trigger")]
        except (sqlite3.Error, UnicodeDecodeError) as error:  # a message of SQLite may quote what is damaged
            connection.close()
            raise _describe_read_error(path, error) from None
        problems = {
            "is a database, but not of a driftform run": application != APPLICATION_ID,
            f"is of format {version}, this driftform reads format {SCHEMA_VERSION}; use the driftform that "
            f"environment.json names{_LAST_COMMITS.get(version, '')}": version != SCHEMA_VERSION,
            f"is damaged; {_NEXT_STEP}": not sound,
            f"is damaged (not as driftform makes them: {', '.join(broken)}); {_NEXT_STEP}": bool(broken),
        }
        if problem := next((text for text, found in problems.items() if found), ""):
            connection.close()
            raise InputError(f"{path}: {problem}")
        # Nothing in the schema may call a function that does more than compute.
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute("PRAGMA synchronous = FULL")
        return cls(connection, path, read_only)

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, and leave it whole without its write-ahead log if no other process reads it."""
        # A reader may hold the log, or the medium be read-only: the log stays, and nothing is lost.
        with suppress(sqlite3.OperationalError):
            if not self._read_only:
                self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
                self._connection.execute("PRAGMA journal_mode = DELETE")
        self._connection.close()

    def read_study(self) -> dict[str, Any]:
        """Return the document of the study that made the run."""
        with self._reading():
            document: dict[str, Any] = json.loads(_ask(self._connection, "SELECT value FROM meta WHERE key = 'study'"))
            if not document.get("targets", True):
                raise ValueError("the study has no targets")
            # Their names are shown before anything else of a study is checked.
            for name in document.get("targets", ()):
                if not name.isprintable():
                    raise ValueError(f"a target is named {name!r}")
            return document

    def write_facts(self, name: str, facts: Mapping[str, Any]) -> None:
        """Store facts about the run under a name, in place of older ones; ``study`` is the document of its study."""
        with self._writing("facts about the run"):
            self._connection.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (name, json.dumps(facts)))

    def read_facts(self, name: str) -> dict[str, Any]:
        """Return the facts that :meth:`write_facts` stored under a name, or an empty dictionary."""
        with self._reading():
            row = self._connection.execute("SELECT value FROM meta WHERE key = ?", (name,)).fetchone()
        found = json.loads(row[0]) if row is not None else {}
        return found if isinstance(found, dict) else {}

    def check_place(self) -> None:
        """Refuse to continue if the file is no longer where it was opened: SQLite would write to it, wherever it is.

        Raises WorkFailedError if the run was moved or deleted.
        """
        if identify_file(self._path) != self._place:
            raise WorkFailedError(
                f"{self._path}: was moved or deleted while the run was under way; if its directory was moved, "
                "resume it where it is now, with all evaluations that were shown"
            )

    def add(self, records: Sequence[Record], targets: Sequence[str], flights: Sequence[DisturbedResult] = ()) -> None:
        """Write evaluations and disturbed flights, all or none; when this returns they survive a crash.

        Raises WorkFailedError if they cannot be written.
        """
        self.check_place()
        # One fsync for all of them: on a disk that makes each wait 4 ms it is what a write costs.
        with self._writing("evaluations"):
            if not self._has_measures:
                self._connection.execute(_TABLES["measured"])
                del self._has_measures
            for record in records:
                fitness = zip(targets, record.evaluation.fitness.tolist(), strict=True)
                scores = [(record.index, target, value) for target, value in fitness]
                with self._naming(f"evaluation {record.index}"):
                    self._connection.execute(_INSERT, _row(record))
                    self._connection.executemany("INSERT INTO score VALUES (?, ?, ?)", scores)
                    found = json.dumps((dict(record.evaluation.measures), dict(record.evaluation.violations)))
                    self._connection.execute("INSERT OR REPLACE INTO measured VALUES (?, ?)", (record.index, found))
            rows = [
                (flight.evaluation, flight.condition, target, value, *offset, flight.failure)
                for flight in flights
                # SQLite stores NaN as NULL.
                for target, value, offset in zip(targets, flight.fitness.tolist(), flight.offsets.tolist(), strict=True)
            ]
            self._connection.executemany("INSERT INTO disturbed VALUES (?, ?, ?, ?, ?, ?, ?, ?)", rows)

    def list_disturbed(self) -> set[tuple[int, int]]:
        """Return the pairs of evaluation and condition that were flown disturbed."""
        with self._reading():
            return set(self._connection.execute("SELECT DISTINCT evaluation, condition FROM disturbed"))

    def read_disturbed(self, target: str, first: int = 0, end: int = MAX_INDEX) -> dict[int, dict[int, float]]:
        """Return the fitness (%) of every disturbed flight, NaN if it says nothing: by evaluation, and by condition.

        Evaluations are those from ``first`` up to ``end``, exclusive.
        """
        query = (
            "SELECT evaluation, condition, fitness, x IS NULL FROM disturbed "
            "WHERE target = ? AND evaluation >= ? AND evaluation < ? ORDER BY evaluation, condition"
        )
        found: dict[int, dict[int, float]] = {}
        with self._reading():
            for index, condition, fitness, failed in self._connection.execute(query, (target, first, end)):
                found.setdefault(index, {})[condition] = nan if failed else float(fitness)
        return found

    def read_flights(
        self, targets: Sequence[str], first: int = 0, end: int = MAX_INDEX
    ) -> dict[tuple[int, int], FloatArray]:
        """Return what :meth:`read_disturbed` does for some targets, (targets,), by pairs of evaluation and condition."""
        columns = [self.read_disturbed(target, first, end) for target in targets]
        return {
            (index, number): np.array([column[index][number] for column in columns])
            for index, flights in columns[0].items()
            for number in flights
        }

    def read_offsets(self, target: str, evaluation: int) -> dict[int, FloatArray]:
        """Return the offset (m, (3,)) of every disturbed flight of an evaluation, by condition.

        It is the vector from the target to the closest approach, NaN for a failed flight.
        """
        query = "SELECT condition, x, y, z FROM disturbed WHERE target = ? AND evaluation = ? ORDER BY condition"
        with self._reading():
            rows = self._connection.execute(query, (target, evaluation)).fetchall()
            return {condition: np.array(offset, dtype=np.float64) for condition, *offset in rows}

    def count(self) -> int:
        """Return the number of evaluations."""
        return int(self._scalar("SELECT COUNT(*) FROM evaluation"))

    def count_failed(self) -> int:
        """Return the number of evaluations that failed."""
        return int(self._scalar("SELECT COUNT(*) FROM evaluation WHERE failure IS NOT NULL"))

    def find_commonest_failure(self) -> tuple[str, int]:
        """Return the first of the commonest kind of failure, and how many there are; ``("", 0)`` without failures."""
        query = "SELECT failure FROM evaluation WHERE failure IS NOT NULL ORDER BY id"
        return find_commonest(str(failure) for (failure,) in self._connection.execute(query))

    def total_seconds(self) -> float:
        """Return the time that all evaluations took together, s."""
        return float(self._scalar("SELECT COALESCE(SUM(seconds), 0) FROM evaluation"))

    def last_index(self) -> int:
        """Return the largest index of an evaluation, -1 before any; some below it may be missing yet."""
        return int(self._scalar("SELECT COALESCE(MAX(id), -1) FROM evaluation"))

    def read_summaries(self, targets: Sequence[str], first: int = 0) -> Iterator[EvaluationSummary]:
        """Yield the summaries of the evaluations from index ``first`` on, in their order, as of one moment."""
        columns = f"id, generation, population, failure, {self._found}" + _SCORE * len(targets)
        query = f"SELECT {columns} FROM evaluation WHERE id >= ? ORDER BY id"
        with self._reading(), closing(self._connection.execute(query, (*targets, first))) as rows:
            for index, generation, population, failure, found, *fitness in rows:
                values = tuple(map(float, fitness))
                yield EvaluationSummary(index, generation, population, failure, values, *_read_found(found))

    def list_constraints(self) -> list[str]:
        """Return the names of the constraints that any evaluation is measured by, in order."""
        # Not by SQLite's own functions of JSON: they know no infinity, such as the time of what never arrives.
        with self._reading():
            rows = self._connection.execute("SELECT found FROM measured") if self._has_measures else ()
            return sorted({name for (found,) in rows for name in _read_found(found)[1]})

    def read_fitness(self, target: str, indices: Sequence[int]) -> dict[int, float]:
        """Return the fitness (%) of the undisturbed flights of evaluations, by evaluation."""
        query = "SELECT fitness FROM score WHERE target = ? AND evaluation = ?"
        with self._reading():
            return {index: float(self._connection.execute(query, (target, index)).fetchone()[0]) for index in indices}

    def read_records(self, targets: Sequence[str], first: int = 0, count: int = -1) -> Iterator[Record]:
        """Yield ``count`` evaluations from index ``first`` on, in their order; ``-1`` for all."""
        # An end in any case: without one, SQLite would read all that follows, to leave it out.
        end = first + count if count >= 0 else MAX_INDEX
        columns = f"{self._found}, evaluation.*" + _SCORE * len(targets)
        query = f"SELECT {columns} FROM evaluation WHERE id >= ? AND id < ? ORDER BY id"
        with self._reading(), closing(self._connection.execute(query, (*targets, first, end))) as rows:
            for row in rows:
                yield self._record(*row)

    def read_trajectories(self) -> Iterator[tuple[int, Trajectory]]:
        """Yield the index and the flight of every evaluation that did not fail, in their order."""
        for record in self.read_records(()):
            if record.evaluation.failure is None and record.evaluation.trajectory is not None:
                yield record.index, record.evaluation.trajectory

    def read_record(self, index: int, targets: Sequence[str]) -> Record:
        """Return one evaluation."""
        return next(self.read_records(targets, index, 1))

    def find_best(self, target: str) -> tuple[int, float] | None:
        """Return index and fitness of the best evaluation for a target, the earliest of equals; ``None`` before any."""
        query = """
            SELECT evaluation, fitness FROM score JOIN evaluation ON id = evaluation
            WHERE target = ? AND failure IS NULL ORDER BY fitness DESC, evaluation LIMIT 1
        """
        with self._reading():
            row = self._connection.execute(query, (target,)).fetchone()
            return (row[0], float(row[1])) if row else None

    @cached_property
    def _grammar(self) -> str | None:
        """Name of the study's grammar, ``None`` if it names none."""
        table = self.read_study().get("grammar")
        return table.get("use") if isinstance(table, dict) else None

    def _scalar(self, query: str) -> Any:
        with self._reading():
            return _ask(self._connection, query)

    @contextmanager
    def _writing(self, what: str) -> Iterator[None]:
        """A transaction that readers do not hold up, nor it them: the first one begins the write-ahead log.

        Raises WorkFailedError if ``what`` cannot be written.
        """
        with self._naming(what):
            self._connection.execute("PRAGMA journal_mode = WAL")
            with _transaction(self._connection):
                yield

    @contextmanager
    def _naming(self, what: str) -> Iterator[None]:
        """Turn errors of writing into a line for users that names what cannot be written."""
        try:
            yield
        except sqlite3.Error as error:
            raise WorkFailedError(f"{self._path}: {what} {_describe_unwritten(error, self._path)}") from None

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """Turn errors of reading into a line for users: damage, or a place that does not let the file be read."""
        try:
            yield
        except sqlite3.ProgrammingError as error:
            # A generator that outlives its store, where it was interrupted, has nothing to close.
            cause: BaseException | None = error
            while cause is not None and not isinstance(cause, GeneratorExit):
                cause = cause.__context__
            if cause is None:
                raise
        except (sqlite3.Error, zlib.error, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise _describe_read_error(self._path, error) from None

    def _record(self, found: str | None, index: int, generation: int, population: str, *row: Any) -> Record:
        parents, grammar, symbols, tuning, seed, failure, ended, _, *rest = row
        contact, drift, error, seconds, blob, *scores = rest
        if self._grammar not in (None, grammar):
            raise ValueError(f"a genome is of the grammar {grammar!r}, expected {self._grammar!r}")
        genome = Genome(grammar, tuple(json.loads(symbols)), tuning)
        fitness = np.array([float(score) for score in scores])
        facts = {"contact": contact, "energy_drift": drift, "error": error}
        flight = None if blob is None else decode(blob, End(ended), **facts)
        candidate = Candidate(genome, tuple(json.loads(parents)), generation, population)
        measures, violations = _read_found(found)
        evaluation = Evaluation(genome, fitness, flight, failure, seconds, measures=measures, violations=violations)
        return Record(index, candidate, evaluation, seed)

    @property
    def _found(self) -> str:
        """A column of what was measured of an evaluation."""
        return "(SELECT found FROM measured WHERE evaluation = id)" if self._has_measures else "NULL"

    @cached_property
    def _has_measures(self) -> bool:
        """Whether measures are stored: not in runs of 0.2.0."""
        return bool(_ask(self._connection, "SELECT count(*) FROM sqlite_master WHERE name = 'measured'"))


def _read_found(found: str | None) -> tuple[dict[str, float], dict[str, float]]:
    """Return measures and violations from what is stored of them."""
    measures, violations = json.loads(found or "[{}, {}]")
    return {str(k): float(v) for k, v in measures.items()}, {str(k): float(v) for k, v in violations.items()}


def _describe_read_error(path: Path, error: Exception) -> DriftformError:
    """Return the error for data that cannot be read: damage, or a place that does not let them be read."""
    code = getattr(error, "sqlite_errorcode", None)
    if code is None or code & 0xFF in _DAMAGE:
        return InputError(f"{path}: is damaged ({describe_error(error)}); {_NEXT_STEP}")
    return WorkFailedError(
        f"{path}: cannot be read here: {error}; the data are untouched: free the disk, or copy the run to a "
        "directory that can be written to, and try again"
    )


def _describe_unwritten(error: Exception, path: Path) -> str:
    return f"cannot be written: {error}; what was written before is safe; free the disk, then: {resume_command(path.parent)}"


def _ask(connection: sqlite3.Connection, query: str) -> Any:
    """Return the first value that a query finds."""
    return connection.execute(query).fetchone()[0]


def _write_empty(path: Path, study: Mapping[str, Any]) -> None:
    """Write a run without evaluations."""
    with closing(sqlite3.connect(path, isolation_level=None)) as connection, _transaction(connection):
        connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
        for statement in _SCHEMA.split(";\n"):
            connection.execute(statement)
        connection.execute("INSERT INTO meta VALUES ('study', ?)", (json.dumps(study),))


def _row(record: Record) -> tuple[Any, ...]:
    """The values of the columns of ``evaluation``."""
    candidate, evaluation = record.candidate, record.evaluation
    flight = compress(evaluation.trajectory) if evaluation.trajectory else None
    return (
        record.index,
        candidate.generation,
        candidate.target,
        json.dumps(candidate.parents),
        candidate.genome.grammar,
        json.dumps(candidate.genome.symbols),
        candidate.genome.tuning,
        record.seed,
        evaluation.failure,
        str(flight.end) if flight else None,
        flight.duration if flight else None,
        *(diagnostics(flight).values() if flight else (None, None, None)),
        evaluation.seconds,
        flight.blob if flight else None,
    )


def _connect(path: Path, read_only: bool = False) -> sqlite3.Connection:
    place = f"{path.resolve().as_uri()}?mode=ro" if read_only else path
    try:
        connection = sqlite3.connect(place, uri=read_only, isolation_level=None)
    except sqlite3.Error as error:
        raise WorkFailedError(f"{path}: cannot be opened: {error}") from None
    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _MAX_ROW_BYTES)
    return connection


@contextmanager
def _transaction(connection: sqlite3.Connection) -> Iterator[None]:
    """All or nothing, also where it is interrupted."""
    connection.execute("BEGIN")
    with connection:
        yield
