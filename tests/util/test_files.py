"""Folders that appear whole or not at all."""

from pathlib import Path

import pytest

from driftform.errors import InputError
from driftform.util.files import write_folder


def test_a_new_folder_replaces_the_former_one(tmp_path):
    former = tmp_path / "model" / "meshes"
    former.mkdir(parents=True)
    (former / "old.obj").write_text("old")
    with write_folder(tmp_path / "model") as part:
        (part / "new.xml").write_text("new")
    assert [path.relative_to(tmp_path).as_posix() for path in sorted(tmp_path.rglob("*"))] == ["model", "model/new.xml"]


@pytest.mark.parametrize("interruption", [RuntimeError, KeyboardInterrupt])
def test_an_interruption_leaves_the_former_folder_as_it_was(tmp_path, interruption):
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "old.xml").write_text("old")
    with pytest.raises(interruption), write_folder(tmp_path / "model") as part:
        (part / "new.xml").write_text("half")
        raise interruption
    assert [path.relative_to(tmp_path).as_posix() for path in sorted(tmp_path.rglob("*"))] == ["model", "model/old.xml"]
    assert (tmp_path / "model" / "old.xml").read_text() == "old"


def test_a_file_in_its_place_is_refused_and_stays(tmp_path):
    (tmp_path / "model").write_text("in the way")
    with pytest.raises(InputError, match="it is a file"), write_folder(tmp_path / "model"):
        pass
    assert (tmp_path / "model").read_text() == "in the way"
    assert list(tmp_path.iterdir()) == [tmp_path / "model"]


def test_the_former_folder_is_restored_if_the_new_one_cannot_replace_it(tmp_path, monkeypatch):
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "old.xml").write_text("old")
    rename = Path.rename

    def fails(self, target):
        if self.name.endswith(".part"):
            raise OSError("no space left")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fails)
    with pytest.raises(OSError, match="no space"), write_folder(tmp_path / "model") as part:
        (part / "new.xml").write_text("new")
    assert (tmp_path / "model" / "old.xml").read_text() == "old"
    assert list(tmp_path.iterdir()) == [tmp_path / "model"]
