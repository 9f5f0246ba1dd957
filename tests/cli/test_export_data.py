"""A run as tables: whole, the same in both formats, and read by pandas and polars."""

import csv
import json
import sqlite3
from pathlib import Path

import numpy as np
import pytest

from driftform.runs import table_files, tables
from driftform.runs.store import Store
from driftform.runs.table_files import SAMPLE_COLUMNS
from driftform.study import Document, load_study

FORMATS = ("csv", "parquet")
TARGETS = ("TP1", "TP7")


@pytest.fixture(scope="module")
def exported(finished_run, run, tmp_path_factory):
    """A folder with the tables of a small real run, in a directory for each format."""
    folder = tmp_path_factory.mktemp("tables")
    for name in FORMATS:
        args = ("--format", name, "--out", folder / name, "--trajectories", "--json")
        result = run("export-data", finished_run[0], *args, cwd=folder)
        assert result.returncode == 0, result.stderr
        document = json.loads(result.stdout)
        assert [file["table"] for file in document["files"]] == ["evaluations", "trajectories"]
        assert all(Path(file["path"]).is_file() for file in document["files"])
        assert document["files"][0]["rows"] == 20
    return folder


def read_file(path):
    """The table as pandas and as polars read it."""
    import pandas
    import polars

    if path.suffix == ".csv":
        # By default pandas reads numbers of CSV files fast and inexactly.
        return pandas.read_csv(path, float_precision="round_trip"), polars.read_csv(path)
    return pandas.read_parquet(path), polars.read_parquet(path)


def read(folder, format, table="evaluations"):
    return read_file(folder / format / f"{table}.{format}")


def column_of(path, name):
    with path.open(newline="") as file:
        return [int(row[name]) for row in csv.DictReader(file)]


def stored(directory):
    with Store.open(directory / "run.db", read_only=True) as store:
        return list(store.read_records(TARGETS))


@pytest.mark.peers
@pytest.mark.parametrize("format", FORMATS)
def test_evaluations_are_those_of_the_run(exported, finished_run, format):
    records = stored(finished_run[0])
    for frame in read(exported, format):
        assert list(frame["evaluation"]) == list(range(20))
        assert list(frame["population"]) == [r.candidate.target for r in records]
        assert list(frame["seconds"]) == [r.evaluation.seconds for r in records]
        assert list(frame["seed"]) == [r.seed for r in records]
        assert list(frame["end"]) == [str(r.evaluation.trajectory.end) for r in records]
        assert list(frame["duration"]) == [float(r.evaluation.trajectory.t[-1]) for r in records]
        for place, target in enumerate(TARGETS):
            assert list(frame[f"fitness_{target}"]) == [float(r.evaluation.fitness[place]) for r in records]
    for name in ("contact", "energy_drift", "error"):
        told = [getattr(r.evaluation.trajectory, name) for r in records]
        in_pandas, in_polars = (frame[name] for frame in read(exported, format))
        assert in_polars.to_list() == told
        np.testing.assert_array_equal(in_pandas, np.array(told, dtype=float))
    # Nothing that failed: no value, and not the word "None".
    in_pandas, in_polars = read(exported, format)
    assert in_pandas["failure"].isna().all()
    assert in_polars["failure"].null_count() == 20


@pytest.mark.peers
def test_a_genome_reads_back_and_its_body_is_as_inspect_tells(exported, finished_run, call):
    _, frame = read(exported, "parquet")
    records = stored(finished_run[0])
    study = load_study(str(finished_run[0] / "resolved.toml"))
    grammar = study.make_plugin("grammar")
    assert [grammar.parse(text) for text in frame["genome"]] == [r.candidate.genome for r in records]
    agent = finished_run[0] / "best" / "TP7" / "agent.json"
    index = json.loads(agent.read_text())["result"]["evaluation"]
    told = json.loads(call("inspect", agent, "--json").stdout)
    row = frame.row(index, named=True)
    assert row["modules"] == len(told["modules"])
    for name in ("length", "max_diameter", "mass", "volume", "net_buoyancy"):
        assert row[name] == told[name]


@pytest.mark.peers
@pytest.mark.parametrize("format", FORMATS)
def test_samples_are_those_that_are_stored_bit_by_bit(exported, finished_run, format):
    records = stored(finished_run[0])
    for frame in read(exported, format, "trajectories"):
        assert list(frame.columns) == [column.name for column in SAMPLE_COLUMNS]
        flights = [r.evaluation.trajectory for r in records]
        np.testing.assert_array_equal(frame["evaluation"], np.repeat(range(20), [len(f.t) for f in flights]))
        whole = np.concatenate([np.column_stack([f.t, f.position, f.quaternion, f.velocity]) for f in flights])
        found = np.column_stack([np.asarray(frame[name]) for name in frame.columns[1:]])
        np.testing.assert_array_equal(found.astype(np.float32), whole.astype(np.float32))


@pytest.mark.peers
def test_every_column_has_a_meaning_and_every_quantity_its_unit(exported):
    from pyarrow import parquet

    for table in ("evaluations", "trajectories"):
        schema = parquet.read_schema(exported / "parquet" / f"{table}.parquet")
        told = json.loads((exported / "csv" / "columns.json").read_text())["tables"][table]
        assert list(told) == schema.names
        for field in schema:
            metadata = {key.decode(): value.decode() for key, value in field.metadata.items()}
            assert metadata == told[field.name]
            assert metadata["meaning"]
    assert told["surge"]["unit"] == "m/s" and told["yaw_rate"]["unit"] == "rad/s" and told["qw"]["unit"] == ""
    evaluations = json.loads((exported / "parquet" / "columns.json").read_text())["tables"]["evaluations"]
    assert (evaluations["mass"]["unit"], evaluations["fitness_TP7"]["unit"]) == ("kg", "%")


def failing(directory, index):
    """As if an evaluation had come to no flight, for a reason that is hard to write."""
    connection = sqlite3.connect(directory / "run.db")
    nothing = ", ".join(
        f"{name} = NULL" for name in ("ended", "duration", "contact", "energy_drift", "error", "trajectory")
    )
    connection.execute(
        f"UPDATE evaluation SET failure = ?, {nothing} WHERE id = ?", ('it said "no",\nand sank; zürich', index)
    )
    connection.execute("UPDATE score SET fitness = 0 WHERE evaluation = ?", (index,))
    connection.commit()
    connection.close()


@pytest.mark.peers
@pytest.mark.parametrize("format", FORMATS)
def test_a_failure_keeps_its_reason_its_zero_fitness_and_its_body(run_copy, call, format):
    failing(run_copy, 7)
    assert call("export-data", "run", "--format", format, "--trajectories").exit_code == 0
    in_pandas, in_polars = read_file(Path(f"run/data/evaluations.{format}"))
    row = in_polars.row(7, named=True)
    assert row["failure"] == in_pandas["failure"][7] == 'it said "no",\nand sank; zürich'
    assert row["end"] is row["duration"] is row["contact"] is None
    assert row["fitness_TP1"] == 0 and row["mass"] > 0
    _, samples = read_file(Path(f"run/data/trajectories.{format}"))
    assert set(samples["evaluation"]) == set(range(20)) - {7}


def test_a_genome_that_has_no_body_is_a_row_without_one(run_copy, monkeypatch):
    with Store.open(run_copy / "run.db", read_only=True) as store:
        study = load_study(Document("run", store.read_study()))
        [record] = store.read_records(TARGETS, 0, 1)

    def refuse(*_):
        raise ValueError("too many modules")

    monkeypatch.setattr("driftform_frusta.builder.FrustaBuilder.build", refuse)
    [batch] = tables.evaluation_batches(study, [record], table_files.evaluation_columns(TARGETS))
    assert batch["modules"] == batch["mass"] == batch["net_buoyancy"] == [None]
    assert batch["fitness_TP1"] == [float(record.evaluation.fitness[0])]


@pytest.mark.peers
@pytest.mark.parametrize("format", FORMATS)
def test_tables_are_written_in_batches_that_fit_into_memory(run_copy, call, exported, monkeypatch, format):
    monkeypatch.setattr(tables, "MAX_ROWS", 6)
    monkeypatch.setattr(tables, "SAMPLES", 2000)
    sizes = []
    write = table_files.FORMATS[format]

    def watching(path, columns, batches):
        def each():
            for batch in batches:
                sizes.append(len(batch["evaluation"]))
                yield batch

        return write(path, columns, each())

    monkeypatch.setitem(table_files.FORMATS, format, watching)
    assert call("export-data", "run", "--format", format, "--trajectories").exit_code == 0
    assert sizes[:4] == [6, 6, 6, 2]
    longest = max(len(r.evaluation.trajectory.t) for r in stored(run_copy))
    assert len(sizes) > 8
    assert all(2000 <= size < 2000 + longest for size in sizes[4:-1])
    for table in ("evaluations", "trajectories"):
        name = f"{table}.{format}"
        found, expected = (read_file(f / name)[1] for f in (run_copy / "data", exported / format))
        assert found.equals(expected)


@pytest.mark.peers
def test_the_folder_of_the_run_is_written_anew_and_holds_nothing_older(run_copy, call):
    folder = run_copy / "data"
    assert call("export-data", "run", "--format", "parquet", "--trajectories").exit_code == 0
    (folder / "notes.txt").write_text("mine")
    result = call("export-data", "run")
    assert result.exit_code == 0
    assert {path.name for path in folder.iterdir()} == {"evaluations.csv", "columns.json", "notes.txt"}
    assert result.stdout.splitlines() == [
        "run/data/evaluations.csv: 20 rows",
        "run/data/columns.json: unit and meaning of each column",
    ]
    assert [path.name for path in run_copy.iterdir() if path.name.endswith(".part")] == []


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError("no space left")])
def test_interrupted_or_failed_it_leaves_what_was_there(run_copy, call, monkeypatch, error):
    assert call("export-data", "run").exit_code == 0
    before = {path: path.read_bytes() for path in run_copy.rglob("*") if path.is_file()}

    def stopping(path, columns, batches):
        path.write_text("half")
        raise error

    monkeypatch.setitem(table_files.FORMATS, "csv", stopping)
    for args in ((), ("--out", "elsewhere")):
        result = call("export-data", "run", *args)
        assert result.exit_code == (130 if error is KeyboardInterrupt else 1)
        assert result.stdout == ""
        assert {path: path.read_bytes() for path in run_copy.rglob("*") if path.is_file()} == before
        assert [path.name for path in run_copy.parent.iterdir()] == ["run"]


def test_a_run_that_goes_on_gives_what_it_has_and_both_tables_agree(run_copy, call, monkeypatch):
    with Store.open(run_copy / "run.db") as writer:
        study, late = writer.read_study(), writer.read_record(19, TARGETS)
    connection = sqlite3.connect(run_copy / "run.db")
    connection.execute("DELETE FROM score WHERE evaluation IN (3, 19)")
    connection.execute("DELETE FROM evaluation WHERE id IN (3, 19)")
    connection.commit()
    connection.close()
    write = table_files.FORMATS["csv"]
    with Store.open(run_copy / "run.db") as writer:

        def while_another_writes(path, columns, batches):
            rows = write(path, columns, batches)
            if path.name == "evaluations.csv":
                writer.add([late], TARGETS)
            return rows

        monkeypatch.setitem(table_files.FORMATS, "csv", while_another_writes)
        result = call("export-data", "run", "--trajectories", "--json")
        assert result.exit_code == 0, result.stderr
        assert writer.count() == 19
        assert writer.read_study() == study
    expected = sorted(set(range(19)) - {3})
    assert column_of(Path("run/data/evaluations.csv"), "evaluation") == expected
    assert sorted(set(column_of(Path("run/data/trajectories.csv"), "evaluation"))) == expected


def test_without_pyarrow_parquet_says_what_to_install_before_anything_is_done(run_copy, call, monkeypatch):
    monkeypatch.setattr(table_files, "find_spec", lambda name: None)
    result = call("export-data", "run", "--format", "parquet")
    assert result.exit_code == 1
    [line] = result.stderr.splitlines()
    assert "pip install 'driftform[parquet]'" in line and "--format csv" in line
    assert not (run_copy / "data").exists()
    assert call("export-data", "run", "--format", "csv").exit_code == 0
