"""Texts that other programs wrote, in the encodings that they come in."""

import codecs

import pytest

from driftform.errors import InputError
from driftform.util import files
from driftform.util.files import find_encoding, read_text


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("a,b\n1,2\n", "ascii"),
        ("Größe,Höhe\n", "utf-8"),
        ("Größe,Höhe\n", "utf-8-sig"),
        ("节点 水\n", "utf-16"),
        ("t,x\n0,1\n", "utf-16-le"),
        ("t,x\n0,1\n", "utf-16-be"),
        ("Größe ÄÖÜ ½ m³ Depósito\n", "cp1252"),
        ("vitesse élevée, création\n", "cp1252"),
        ("“Tanque” – ção\n", "cp1252"),
        (" P1 R1 节点 500 200\n 水 管道 阀门\n", "gbk"),
    ],
)
def test_a_text_is_read_in_its_encoding(tmp_path, text, encoding):
    path = tmp_path / "text.txt"
    path.write_bytes(text.encode(encoding))
    assert read_text(path) == text


def test_utf16_of_either_byte_order_has_its_mark(tmp_path):
    path = tmp_path / "text.txt"
    for mark, name in ((codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be")):
        path.write_bytes(mark + "größer".encode(name))
        assert read_text(path) == "größer"


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_by_newlines_whatever_system_wrote_them(tmp_path, end):
    path = tmp_path / "text.txt"
    path.write_bytes(f"a{end}b{end}".encode())
    assert read_text(path) == "a\nb\n"


@pytest.mark.parametrize("data", [b"\xff\xfe\x00", b"\x89PNG\r\n\x1a\n\0\0\0", b"PK\x03\x04\0\0"])
def test_what_is_no_text_is_refused_in_one_line(tmp_path, data):
    (tmp_path / "text.txt").write_bytes(data)
    with pytest.raises(InputError, match=r"text\.txt: is not a text file; save it as text in UTF-8"):
        read_text(tmp_path / "text.txt")


def test_a_text_too_large_or_missing_is_refused(tmp_path, monkeypatch):
    (tmp_path / "text.txt").write_text("x" * 11)
    monkeypatch.setattr(files, "MAX_BYTES", 10)
    with pytest.raises(InputError, match="is larger than"):
        read_text(tmp_path / "text.txt")
    with pytest.raises(InputError, match="cannot be read"):
        read_text(tmp_path / "missing.txt")


def test_a_character_cut_at_the_end_of_a_beginning_does_not_matter():
    begin = "größe 节点".encode()[:-1]
    assert find_encoding(begin) == "utf-8-sig"
    assert find_encoding(begin, final=True) != "utf-8-sig"
