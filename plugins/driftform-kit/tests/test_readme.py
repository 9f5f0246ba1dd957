"""The example of the README."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"


def test_the_example_weighs_a_kit_and_lists_its_parts(capsys):
    [source] = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(source, str(README), "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(" shell")[0] for line in lines if "shell" in line] == ["aft", "fore"]
    assert float(lines[-1]) == pytest.approx(0.0391, abs=5e-5)
