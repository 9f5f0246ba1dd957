"""What goes into a run's database comes out again, and a strategy cannot tell a resumed run from a live one."""

import math
import pickle
import sqlite3
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from driftform.errors import InputError, WorkFailedError
from driftform.runs import compression
from driftform.runs.compression import SAMPLE_GAP, compress, compress_evaluation, decode, diagnostics, encode
from driftform.runs.store import Record, Store
from driftform.types import Candidate, End, Evaluation, Genome, Trajectory, same_content

TARGETS = ("A", "B")
COLUMNS = ("t", "position", "quaternion", "velocity")

texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
genomes = st.builds(Genome, texts, st.lists(texts, max_size=5).map(tuple), st.floats(0, 1))
candidates = st.builds(
    Candidate, genomes, st.lists(st.integers(0, 9**9), max_size=2).map(tuple), st.integers(0, 999), texts
)


@st.composite
def trajectories(draw):
    count = draw(st.integers(1, 60))
    gaps = draw(st.lists(st.floats(1e-4, 0.05), min_size=count - 1, max_size=count - 1))
    t = np.concatenate([[0.0], np.cumsum(gaps)])
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    rest = rng.normal(scale=3, size=(count, 13))
    trust = [draw(st.none() | st.floats(0, math.inf)) for _ in range(3)]
    return Trajectory(t, rest[:, :3], rest[:, 3:7], rest[:, 7:], draw(st.sampled_from(End)), *trust)


@st.composite
def records(draw, index=0):
    candidate = draw(candidates)
    evaluation = Evaluation(
        candidate.genome,
        np.array(draw(st.lists(st.floats(0, 100), min_size=2, max_size=2))),
        draw(st.none() | trajectories()),
        draw(st.none() | texts),
        draw(st.floats(0, 1e6)),
        measures=draw(st.dictionaries(texts, st.floats(), max_size=3)),
        violations=draw(st.dictionaries(texts, st.floats(0), max_size=2)),
    )
    return Record(index, candidate, evaluation, draw(st.integers(0, 2**63 - 1)))


def same(a, b):
    flights = (a.trajectory, b.trajectory)
    return (
        (a.genome, a.failure, a.seconds) == (b.genome, b.failure, b.seconds)
        and same_content((a.measures, a.violations), (b.measures, b.violations))
        and a.fitness.tobytes() == b.fitness.tobytes()
        and (flights[0] is None) == (flights[1] is None)
        and all(
            f is None or g is None or getattr(f, name).tobytes() == getattr(g, name).tobytes()
            for f, g in [flights]
            for name in COLUMNS
        )
        and all(
            getattr(flights[0], name, None) == getattr(flights[1], name, None)
            for name in ("end", "contact", "energy_drift", "error")
        )
    )


@pytest.fixture
def store(tmp_path):
    with Store.create(tmp_path / "run.db", {"title": "of a test"}) as store:
        yield store


@pytest.fixture
def fresh(tmp_path_factory):
    return lambda: tmp_path_factory.mktemp("store") / "run.db"


@given(st.data())
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_records_read_back_as_a_live_strategy_has_seen_them(fresh, data):
    written = [data.draw(records(index)) for index in range(data.draw(st.integers(0, 3)))]
    path = fresh()
    with Store.create(path, {}) as store:
        for record in written:
            store.add([record], TARGETS)
    with Store.open(path) as store:
        read = list(store.read_records(TARGETS))
        assert store.count() == len(written)
        assert store.count_failed() == sum(r.evaluation.failure is not None for r in written)
        flights = dict(store.read_trajectories())
        assert store.list_constraints() == sorted({name for r in written for name in r.evaluation.violations})
    assert [(r.index, r.candidate, r.seed) for r in read] == [(r.index, r.candidate, r.seed) for r in written]
    sound = {r.index: r.evaluation for r in read if r.evaluation.failure is None and r.evaluation.trajectory}
    assert list(flights) == list(sound)
    assert all(same(replace(e, trajectory=flights[i]), e) for i, e in sound.items())
    for before, after in zip(written, read, strict=True):
        assert same(after.evaluation, compress_evaluation(before.evaluation))
        assert after.evaluation.fitness.tobytes() == before.evaluation.fitness.tobytes()


@given(trajectories())
def test_a_stored_flight_keeps_its_ends_and_is_within_single_precision_between(flight):
    kept = decode(encode(flight), flight.end)
    assert kept.end == flight.end
    assert kept.t[0] == 0.0
    assert kept.t[-1] == np.float32(flight.t[-1])
    assert (np.diff(kept.t) > 0).all()
    # Every sample that is left is one that was there, and no gap opens where there was none.
    places = np.searchsorted(flight.t.astype(np.float32), kept.t.astype(np.float32))
    for name in COLUMNS:
        original = getattr(flight, name)[places].astype(np.float32)
        assert (getattr(kept, name) == original).all()
    widest = max(np.diff(flight.t), default=0.0)
    assert max(np.diff(kept.t), default=0.0) <= widest + 2 * SAMPLE_GAP


@given(trajectories(), st.sampled_from([0.0, -0.0, 1.0]))
def test_what_is_zero_all_along_takes_no_room_and_keeps_its_sign(flight, sway):
    velocity = flight.velocity.copy()
    velocity[:, 1] = sway
    swaying = encode(replace(flight, velocity=velocity))
    velocity[:, 1] = 0.0
    straight = encode(replace(flight, velocity=velocity))
    kept = decode(swaying, flight.end)
    assert (np.signbit(kept.velocity[:, 1]) == np.signbit(sway)).all()
    assert (kept.velocity[:, 1] == sway).all()
    is_stored = bool(np.signbit(sway)) or sway != 0.0
    assert (len(swaying) > len(straight)) == is_stored


def evaluated(index, a, b, failure=None):
    genome = Genome("g", (str(index),))
    return Record(index, Candidate(genome), Evaluation(genome, np.array([a, b]), failure=failure))


def test_reading_one_evaluation_takes_no_longer_in_a_large_run(store):
    def steps():
        """Instructions of SQLite's machine that it takes."""
        count = [0]
        store._connection.set_progress_handler(lambda: count.__setitem__(0, count[0] + 1), 1)
        store.read_record(1, TARGETS)
        store._connection.set_progress_handler(None, 1)
        return count[0]

    store.add([evaluated(index, 1.0, 2.0) for index in range(3)], TARGETS)
    small = steps()
    store.add([evaluated(index, 1.0, 2.0) for index in range(3, 1000)], TARGETS)
    assert small > 10
    assert steps() <= small + 10


def test_a_run_of_an_earlier_version_has_no_measures_and_gets_those_of_what_is_added(tmp_path):
    with Store.create(tmp_path / "run.db", {}) as store:
        store.add([evaluated(0, 1, 2)], TARGETS)
    with closing(sqlite3.connect(tmp_path / "run.db")) as connection:
        connection.execute("DROP TABLE measured")
    with Store.open(tmp_path / "run.db", read_only=True) as old:
        assert old.read_record(0, TARGETS).evaluation.measures == {}
    with Store.open(tmp_path / "run.db") as old:
        record = evaluated(1, 1, 2)
        old.add([replace(record, evaluation=replace(record.evaluation, measures={"mass": 0.1}))], TARGETS)
        assert [found.evaluation.measures for found in old.read_records(TARGETS)] == [{}, {"mass": 0.1}]


def test_the_best_is_the_earliest_of_equals_and_never_a_failure(store):
    assert store.find_best("A") is None
    for record in (
        evaluated(0, 5.0, 1.0),
        evaluated(1, 9.0, 1.0),
        evaluated(2, 9.0, 0.5),
        evaluated(3, 99.0, 99.0, failure="it sank"),
    ):
        store.add([record], TARGETS)
    assert store.find_best("A") == (1, 9.0)
    assert store.find_best("B") == (0, 1.0)
    assert store.find_best("C") is None


def test_of_what_is_added_together_all_is_written_once_or_nothing(store):
    store.add([evaluated(index, 1.0, 2.0) for index in range(3)], TARGETS)
    for wrong in (evaluated(2, 1.0, 2.0), evaluated(4, float("nan"), 2.0)):
        with pytest.raises(WorkFailedError, match=f"evaluation {wrong.index} cannot be written"):
            store.add([evaluated(3, 1.0, 2.0), wrong, evaluated(5, 1.0, 2.0)], TARGETS)
    assert [record.index for record in store.read_records(TARGETS)] == [0, 1, 2]
    store.add([evaluated(3, 1.0, 2.0)], TARGETS)
    assert store.count() == 4


def test_a_full_disk_is_reported_and_what_was_there_stays(store):
    store.add([evaluated(0, 1.0, 2.0)], TARGETS)
    pages = store._connection.execute("PRAGMA page_count").fetchone()[0]
    store._connection.execute(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(WorkFailedError, match=r"cannot be written: database or disk is full; .* is safe"):
        store.add([evaluated(index, 1.0, 2.0) for index in range(1, 500)], TARGETS)
    assert store.count() == 1


def test_a_file_that_could_not_be_begun_is_not_there(tmp_path):
    with pytest.raises(TypeError):
        Store.create(tmp_path / "run.db", {"no JSON": object()})
    assert list(tmp_path.iterdir()) == []


@given(trajectories())
def test_a_packed_flight_is_the_one_that_reads_back_and_travels_as_bytes(flight):
    once = compress(flight)
    assert compress(once) is once
    travelled = pickle.loads(pickle.dumps(once))
    assert "position" not in vars(travelled)
    assert (travelled.blob, travelled.duration) == (encode(flight), once.t[-1])
    back = decode(encode(flight), flight.end, **diagnostics(flight))
    for name in (*COLUMNS, "end", "contact", "energy_drift", "error"):
        assert np.array_equal(getattr(travelled, name), getattr(back, name))
    for name in COLUMNS:
        # As kernels are compiled for.
        assert all(getattr(f, name).flags.c_contiguous for f in (travelled, back))
        assert not any(getattr(f, name).flags.writeable for f in (travelled, back))
    shifted = replace(travelled, t=travelled.t + 1.0)
    assert compress(shifted).t[0] == 1.0
    with pytest.raises(AttributeError, match="colour"):
        _ = travelled.colour


def test_a_part_of_the_records_is_read_by_index(store):
    for index in range(5):
        store.add([evaluated(index, index, 0.0)], TARGETS)
    assert [record.index for record in store.read_records(TARGETS, 1, 3)] == [1, 2, 3]
    assert [record.index for record in store.read_records(TARGETS, 3)] == [3, 4]
    assert list(store.read_records(TARGETS, 9, 2)) == []


def test_the_scores_come_in_the_order_that_is_asked_for(store):
    store.add([evaluated(0, 1.0, 2.0)], TARGETS)
    assert store.read_record(0, ("B", "A")).evaluation.fitness.tolist() == [2.0, 1.0]


def test_a_reader_that_closes_leaves_the_log_to_the_writer(store, tmp_path):
    store.add([evaluated(0, 1.0, 2.0)], TARGETS)
    with Store.open(tmp_path / "run.db") as reader:
        assert reader.count() == 1
    store.add([evaluated(1, 1.0, 2.0)], TARGETS)
    assert store.count() == 2


@pytest.mark.parametrize(
    "read", [lambda store: store.read_records(TARGETS), lambda store: store.read_summaries(TARGETS)]
)
def test_a_reading_that_outlives_its_store_calls_no_sound_file_damaged(store, tmp_path, read):
    store.add([evaluated(index, 1.0, 2.0) for index in range(3)], TARGETS)
    with Store.open(tmp_path / "run.db", read_only=True) as reader:
        reading = read(reader)
        next(reading)
    reading.close()


def test_an_existing_file_is_never_made_anew(store, tmp_path):
    store.add([evaluated(0, 1.0, 2.0)], TARGETS)
    with pytest.raises(InputError, match="exists already"):
        Store.create(tmp_path / "run.db", {})
    assert store.count() == 1


def test_where_nothing_can_be_written_it_says_so(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(WorkFailedError, match="cannot be written"):
        Store.create(tmp_path / "file" / "run.db", {})
    with pytest.raises(InputError, match="no such file"):
        Store.open(tmp_path / "run.db")


def test_a_hundred_metres_a_day_long_keep_apart_in_single_precision(store):
    # The last two samples are nearer than the time can tell apart so late in a flight.
    t = np.array([0.0, 50_000.0, 50_000.0001])
    rest = np.zeros((3, 13))
    flight = Trajectory(t, rest[:, :3], rest[:, 3:7], rest[:, 7:], End.HORIZON)
    kept = decode(encode(flight), flight.end)
    assert (np.diff(kept.t) > 0).all()


class Refusing:
    """A connection to a database that cannot be read, for the reason of a code."""

    def __init__(self, code):
        self._code = code

    def execute(self, *_):
        error = sqlite3.OperationalError("so it is")
        error.sqlite_errorcode = self._code
        raise error

    def close(self): ...


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        (sqlite3.SQLITE_CORRUPT, InputError),
        (sqlite3.SQLITE_NOTADB, InputError),
        (sqlite3.SQLITE_FULL, WorkFailedError),
        (sqlite3.SQLITE_READONLY, WorkFailedError),
        (sqlite3.SQLITE_READONLY_DIRECTORY, WorkFailedError),
        (sqlite3.SQLITE_BUSY, WorkFailedError),
        (sqlite3.SQLITE_CANTOPEN, WorkFailedError),
        (sqlite3.SQLITE_IOERR_READ, WorkFailedError),
    ],
)
def test_only_a_damaged_file_is_called_damaged(tmp_path, code, expected):
    with Store.create(tmp_path / "run.db", {}) as store:
        readable, store._connection = store._connection, Refusing(code)  # type: ignore[assignment]
        with pytest.raises(expected) as caught:
            store.count()
        store._connection = readable
    text = str(caught.value)
    assert ("is damaged" in text) == (expected is InputError)
    assert ("cannot be read here: so it is; the data are untouched" in text) == (expected is WorkFailedError)


def test_a_flight_that_no_reader_would_unpack_is_not_stored(monkeypatch):
    monkeypatch.setattr(compression, "MAX_FLIGHT_BYTES", 100 * 14 * 4)
    for count, is_refused in ((100, False), (101, True)):
        t = 2 * SAMPLE_GAP * np.arange(float(count))
        rest = np.zeros((count, 6))
        flight = Trajectory(t, rest[:, :3], rest[:, :4], rest, End.OUTLET)
        if is_refused:
            with pytest.raises(ValueError, match="has more samples than a run can hold"):
                encode(flight)
        else:
            assert (decode(encode(flight), flight.end).t == t.astype(np.float32)).all()


def test_damage_that_sqlite_describes_with_the_damaged_bytes_is_one_line(tmp_path):
    path = tmp_path / "run.db"
    Store.create(path, {"targets": {"A": (1.0, 0.0, 0.0)}}).close()
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("PRAGMA writable_schema = ON")
        connection.execute(
            "UPDATE sqlite_master SET name = CAST(x'6dd061' AS TEXT), sql = 'no SQL' WHERE name = 'meta'"
        )
    with pytest.raises(InputError, match="is damaged") as raised:
        Store.open(path, read_only=True)
    assert len(str(raised.value).splitlines()) == 1
