"""What docs/printing.md tells of kits: the numbers of random agents, and the pause in which the core is put in."""

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from driftform.cli.app import app
from driftform.study import load_study


def test_of_a_hundred_random_agents(pages):
    from driftform_frusta.kit_options import PartOptions
    from driftform_kit.cutting.pieces import make_kit

    pipeline, rng = load_study("paper", run={"seed": 0}).make_pipeline(), np.random.default_rng(1)
    options = PartOptions(kit=True)
    places = []
    for _ in range(100):
        joint = make_kit(pipeline.make_agent(pipeline.grammar.random(rng)).body, options).core_joint
        if joint.kind == "sleeve":
            places.append(abs(joint.z))
    page = re.sub(r"\s+", " ", pages["printing.md"])
    assert f"{min(places):.0f} to {max(places):.0f} mm, on a side that stays as wide as the core" in page


@pytest.mark.long
@pytest.mark.peers
def test_the_pause_of_the_page_comes_once_before_the_first_layer_above_its_height(blocks, tmp_path, monkeypatch):
    if shutil.which("prusa-slicer") is None:
        pytest.skip("prusa-slicer is not installed")
    monkeypatch.chdir(tmp_path)
    word = "-".join(["addF-tiltp-0-L-moveF"] * 3)
    made = CliRunner().invoke(app, ["export", word, "--kit", "--format", "3mf", "--out", "."])
    assert made.exit_code == 0, made.output
    next(tmp_path.glob("*.3mf")).rename("r1-TP5.3mf")
    [block] = [b for b in blocks if b.page == "printing.md" and "before-layer-gcode" in b.text]
    command = shlex.split(block.text.replace("\\\n", " "))
    subprocess.run(command, check=True, capture_output=True)
    printed = Path("r1-TP5.gcode").read_text(encoding="utf-8")
    commands = [line for line in printed.splitlines() if line.startswith((";Z:", "M601", ";TYPE:Skirt/Brim"))]
    assert commands.count("M601") == 1 and ";TYPE:Skirt/Brim" in commands
    place = commands.index("M601")
    below, above = (float(line[3:]) for line in commands[place - 2 : place])
    assert below <= 12.5 < above
