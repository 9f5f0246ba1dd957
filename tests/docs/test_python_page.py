"""The examples of docs/python.md, one after the other, and the notebook that goes with it."""

import inspect
import json
import shutil
import warnings
from pathlib import Path

import pytest
from shared import shared_folder

import driftform

PAGE = "python.md"
NOTEBOOK = Path(__file__).parents[2] / "docs" / "notebooks" / "first-steps.ipynb"


@pytest.mark.peers
def test_the_examples_print_and_write_what_they_are_about(blocks, run_example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    out = {b.file: run_example(PAGE, b.file)[0] for b in blocks if b.page == PAGE and b.language == "python"}
    assert "passes TP3 by" in out["first.py"]
    assert (tmp_path / "parts" / "tp3.3mf").stat().st_size > 84
    assert (tmp_path / "runs" / "first" / "best" / "TP7" / "agent.json").is_file()
    assert out["study.py"].startswith("0.8 m/s, 500 evaluations\n") and "did you mean 'speed'?" in out["study.py"]
    assert all(part in out["run.py"] for part in ("TP3:", "TP7:", "fitness_TP3", "passes by"))
    assert (tmp_path / "first.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    assert (tmp_path / "tables" / "evaluations.csv").is_file()
    assert out["agents.py"].count(" m/s: ") == 3
    assert (tmp_path / "parts" / "by_hand.svg").is_file()
    assert (tmp_path / "flights" / "tp3.csv").read_text(encoding="utf-8").count("\n") > 50
    assert (tmp_path / "flights" / "tp3.png").read_bytes().startswith(b"\x89PNG")
    assert "9 of 10 disturbed flights miss by less than" in out["flights.py"]
    assert 'width="85mm"' in (tmp_path / "flights" / "figure.svg").read_text(encoding="utf-8")
    assert out["more.py"].startswith("Body(") and out["more.py"].endswith(" %\n")
    assert "failed checks of the file: []" in out["print.py"] and "ballast: 2.00 g at x" in out["print.py"]


@pytest.mark.long
def test_the_example_of_the_page_of_calibration_fits_a_drag(docs, run_example, tmp_path, monkeypatch):
    shutil.copytree(docs / "tracks", tmp_path / "tracks")
    monkeypatch.chdir(tmp_path)
    factor, residual = map(float, run_example("calibration.md", "calibrate_example.py")[0].split())
    assert factor == pytest.approx(1.14, abs=0.02)
    assert 0 < residual < 0.002


@pytest.mark.long
@pytest.mark.peers
def test_the_example_of_the_page_of_networks_shows_what_bodies_see(run_example, tmp_path_factory, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(shared_folder(tmp_path_factory, "networks")))
    assert run_example("networks.md", "town.py")[0] == "water 0.297, sphere 0.289, five spheres 0.350\n"


def test_ten_lines_are_enough(blocks):
    [block] = [b for b in blocks if b.page == PAGE and b.file == "first.py"]
    assert len([line for line in block.text.splitlines() if line]) <= 10


def test_each_method_of_a_design_and_of_a_run_is_on_the_page(pages):
    from driftform.api import Run
    from driftform.design.design import Design

    wanted = {
        Design: ("inspect", "simulate", "disturb", "export", "record", "still", "film", "under"),
        Run: ("pick", "report", "export_data", "evaluations", "best"),
    }
    for cls, names in wanted.items():
        assert [name for name in names if not hasattr(cls, name) or f".{name}(" not in pages[PAGE]] == []


def test_the_notebook_is_stored_without_outputs():
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code and all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


@pytest.mark.peers
def test_the_notebook_runs_and_shows_pictures(tmp_path):
    with warnings.catch_warnings():
        # The packages of Jupyter announce to each other what they will change.
        warnings.simplefilter("ignore", DeprecationWarning)
        import nbformat
        from nbclient import NotebookClient

    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    shown = [output.data for output in outputs if output.output_type == "execute_result"]
    assert sum("text/html" in data for data in shown) == 4
    assert sum("image/svg+xml" in data for data in shown) == 2
    assert " ".join(shown[-1]["text/plain"].split()).startswith("['tp3.3mf', 'tp3-assembly-1.svg'")
    assert [output for output in outputs if output.output_type == "error"] == []


@pytest.mark.peers
def test_a_notebook_shows_one_bar_and_one_line_of_an_error(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import nbformat
        from nbclient import NotebookClient

    cells = [
        "from driftform.util.progress import count_progress\n"
        "with count_progress('flights') as show:\n    for done in range(1, 101): show(done, 100)",
        "import driftform as df\ndf.load_study('tank', ['flow.sped=1'])",
    ]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    client = NotebookClient(notebook, timeout=600, allow_errors=True, resources={"metadata": {"path": str(tmp_path)}})
    client.execute()
    [bar], [error] = (cell.outputs for cell in notebook.cells)
    assert bar.output_type == "display_data", "one display, which changes; nothing on stderr"
    assert bar.data["text/plain"].startswith("100/100 flights, ")
    assert '<progress value="100" max="100">' in bar.data["text/html"]
    assert error.traceback == [
        "InputError: settings: 'flow.sped=1': unknown key 'sped' in [flow]; did you mean 'speed'?"
    ]


def test_every_function_of_the_package_is_on_the_page(pages):
    functions = {name for name in driftform.__all__ if inspect.isfunction(getattr(driftform, name))}
    assert len(functions) >= 4
    assert [name for name in functions if f"df.{name}(" not in pages[PAGE]] == []
