"""Third-party code: a call in a process of its own gives data or one error, whatever the other side does."""

import sys
from pathlib import Path

import numpy as np
import parsers
import pytest

from driftform.errors import InputError, WorkFailedError
from driftform.util import foreign


def test_numbers_texts_and_arrays_come_back_as_they_went():
    array = np.arange(6.0).reshape(2, 3).T
    back = foreign.call_apart(parsers.give_back, array, {"a": [1, 2.5, None, "é"]}, (True, b"x"), np.float64(2))
    np.testing.assert_array_equal(back[0], array)
    assert back[1:] == ({"a": [1, 2.5, None, "é"]}, (True, b"x"), 2.0)


def test_an_answer_that_names_code_is_refused():
    with pytest.raises(ValueError, match="gives no data"):
        foreign.call_apart(parsers.give_code)


@pytest.mark.parametrize(
    ("kind", "error", "text"),
    [
        ("input", InputError, "words"),
        ("work", WorkFailedError, "words"),
        ("value", ValueError, "words"),
        ("module", ModuleNotFoundError, "words"),
        ("key", ValueError, "cannot be read: KeyError: 'words'"),
        ("file", ValueError, "cannot be read: words"),
    ],
)
def test_errors_cross_as_one_of_few_kinds(kind, error, text):
    with pytest.raises(error) as raised:
        foreign.call_apart(parsers.fail, kind, "words")
    assert type(raised.value) is error and str(raised.value) == text


def test_an_endless_loop_ends_by_its_processor_time():
    with pytest.raises(ValueError, match="cannot be read within 1 s"):
        foreign.call_apart(parsers.loop, seconds=1)


def test_a_call_that_waits_for_ever_is_ended(monkeypatch):
    monkeypatch.setattr(foreign, "_PATIENCE", 1)
    with pytest.raises(ValueError, match="cannot be read within 2 s"):
        foreign.call_apart(parsers.sleep, seconds=2)


@pytest.mark.skipif(sys.platform != "linux", reason="others have no strict limit of memory")
def test_memory_is_limited():
    with pytest.raises(ValueError, match="more than 500 MB of memory"):
        foreign.call_apart(parsers.take_memory, memory=500 << 20)


@pytest.mark.parametrize(("function", "words"), [(parsers.crash, "SIGABRT"), (parsers.leave, "SystemExit: 3")])
def test_a_crash_is_an_error_of_one_line(function, words):
    with pytest.raises(ValueError, match=words) as raised:
        foreign.call_apart(function)
    assert "\n" not in str(raised.value)


def test_what_is_called_works_in_a_folder_that_goes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder, [path] = (foreign.call_apart(parsers.leave_files), foreign.call_apart(parsers.give_back, Path("here")))
    assert list(tmp_path.iterdir()) == [] and not Path(folder).exists()
    assert path == str(tmp_path / "here")


def test_the_output_of_a_program_is_returned_whatever_its_exit_code(tmp_path):
    command = [sys.executable, "-c", "import sys; print('out'); print('err', file=sys.stderr); sys.exit(7)"]
    assert sorted(foreign.run_program(command, tmp_path, 20, 1 << 30).split()) == ["err", "out"]


def test_a_program_that_does_not_end_or_is_not_there_fails(tmp_path):
    with pytest.raises(WorkFailedError, match="did not end within 1 s"):
        foreign.run_program([sys.executable, "-c", "while True: pass"], tmp_path, 1, 1 << 30)
    with pytest.raises(WorkFailedError, match="not on PATH"):
        foreign.run_program(["no-such-program"], tmp_path, 1, 1 << 30)


def test_a_module_that_is_missing_is_named():
    foreign.require_module("json")
    with pytest.raises(ModuleNotFoundError, match="no_such_module"):
        foreign.require_module("no_such_module")
