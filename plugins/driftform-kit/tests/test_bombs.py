"""Small files that ask for more memory or time than there is: refused in one line, quickly."""

import sys
import time

import pytest
from prints import mesh_xml, write_3mf

from driftform.errors import InputError
from driftform.util.foreign import run_program
from driftform_kit.reading import read_meshes

MESH = mesh_xml()
CROWDED = MESH.replace("<vertices>", "<vertices>" + 2000 * '<vertex x="0" y="0" z="0"/>')


def nested(levels, copies):
    """Objects of which each places several copies of the one before."""
    found = f'<object id="0">{MESH}</object>'
    for level in range(1, levels + 1):
        component = f'<component objectid="{level - 1}"/>'
        found += f'<object id="{level}"><components>{copies * component}</components></object>'
    return found


@pytest.mark.long
@pytest.mark.parametrize(
    ("objects", "items", "reason"),
    [
        (nested(30, 2), '<item objectid="30"/>', "places more than 10000 meshes"),
        (nested(1, 1), 20_000 * '<item objectid="1"/>', "places more than 10000 meshes"),
        (
            f'<object id="0">{CROWDED}</object>',
            9_000 * '<item objectid="0"/>',
            "has more than 5000000 triangles or vertices",
        ),
        (f'<object id="0">{MESH}</object>' + " " * (130 << 20), '<item objectid="0"/>', "unpacks to more than 128 MB"),
    ],
    ids=["components of components", "many items", "many copies of many vertices", "much air"],
)
def test_a_3mf_that_grows_without_end_is_refused(tmp_path, objects, items, reason):
    path = write_3mf(tmp_path / "bomb.3mf", objects, items)
    assert path.stat().st_size < 1 << 20
    began = time.process_time()
    with pytest.raises(InputError, match=reason):
        read_meshes(path)
    assert time.process_time() - began < 20


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")
def test_a_program_gets_no_more_memory_than_it_is_allowed(tmp_path):
    greedy = [sys.executable, "-c", "print(len(bytes(1 << 30)))"]
    assert run_program(greedy, tmp_path, 60).strip() == str(1 << 30)
    assert "MemoryError" in run_program(greedy, tmp_path, 60, memory=1 << 29)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limits")
def test_a_program_that_prints_without_end_fills_no_memory(tmp_path):
    chatty = [sys.executable, "-c", "import sys\nwhile True: sys.stdout.write('x' * 65536)"]
    assert len(run_program(chatty, tmp_path, 100)) <= 1 << 24
