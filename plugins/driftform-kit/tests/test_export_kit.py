"""``export --kit``: files for each part, the balance of the kit, and clear lines where there can be none."""

import json
import shlex

import pytest
import trimesh

pytestmark = pytest.mark.usefixtures("ideal_water")

LONG = "addF-tiltp-0-L-moveF-addF-tiltp-0-L-moveF-addF-tiltp-0-L-moveF-addB-tiltn-1-L-moveB-addB-tiltn-1-L-moveB"
"""Straight ahead of the core, narrower behind it."""


def files(call, *arguments, agent=LONG):
    """What the command says of files with parts; the assembly sheets are left out."""
    found = json.loads(call("export", agent, *arguments, "--json").stdout)["files"]
    return [file for file in found if "-assembly-" not in file["path"]]


def test_each_part_gets_a_file_and_each_file_tells_of_the_kit(call, tmp_path):
    aft, fore = files(call, "--kit", "--out", str(tmp_path))
    assert aft["path"].endswith("-aft-shell.stl") and fore["path"].endswith("-fore-shell.stl")
    assert aft["kit"] == fore["kit"]
    assert aft["kit"]["joint"]["kind"] == "sleeve"
    for told, part in zip((aft, fore), aft["kit"]["parts"], strict=True):
        mesh = trimesh.load_mesh(told["path"])
        assert mesh.is_watertight
        assert mesh.extents[2] == pytest.approx(part["height_mm"], rel=1e-5)
        assert 1e-9 * mesh.volume * 1050 == pytest.approx(part["mass_kg"], rel=1e-5)


def test_the_assembly_sheet_is_written_once_for_all_formats(call, tmp_path):
    out = call("export", LONG, "--kit", "--format", "stl,3mf,glb", "--out", str(tmp_path)).stdout
    pages = sorted(page.name for page in tmp_path.glob("*.svg"))
    assert [page[-15:] for page in pages] == ["-assembly-1.svg", "-assembly-2.svg"]
    assert [out.count(page) for page in pages] == [1, 1]
    call("export", LONG, "--format", "stl", "--out", str(tmp_path / "whole"))
    assert not list((tmp_path / "whole").glob("*.svg"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--kit", "--format", "svg"), "--kit: exporter 'svg' has no option 'kit'; 3mf, glb, obj, ply, scad"),
        (("--option", "jiont=rabbet"), "exporter 'stl' has no option 'jiont'; did you mean 'joint'?"),
        (("--option", "joint"), "--option joint: expected key=value, such as joint=rabbet"),
        (("--kit", "--option", "joint=screw"), "error: --option joint=screw: exporter.stl.joint = 'screw': should be"),
    ],
)
def test_what_makes_no_sense_is_one_line(refused, arguments, message):
    assert message in refused("export", LONG, *arguments, "--out", "parts")


def test_a_kit_that_cannot_be_made_leaves_no_file(call, tmp_path):
    result = call("export", LONG, "--kit", "--bed", "15,15,15", "--out", str(tmp_path))
    assert result.exit_code == 1
    assert result.stderr.startswith("error: no kit can be made: the hull is")
    assert not list(tmp_path.iterdir())


def test_the_note_on_kits_is_for_formats_that_have_them(call, tmp_path):
    made = ("--set", "builder.made_as=kit", "--out", str(tmp_path))
    assert "write them with --kit" in call("export", LONG, *made, "--format", "stl").stderr
    assert "--kit" not in call("export", LONG, *made, "--format", "sdf").stderr


@pytest.mark.long
def test_sheets_in_the_folder_of_a_run_name_the_agent_as_commands_take_it(call, tmp_path):
    run = tmp_path / "run 2"
    formats = ("--set", 'run.formats=["stl"]', "--set", "exporter.stl.kit=true")
    few = ("--target", "TP5", "--evaluations", "8", "--seed", "4", "--workers", "1", "--robust", "0")
    assert call("evolve", *few, "--simulator", "native", *formats, "--out", str(run)).exit_code == 0
    sheet = (run / "best/TP5/agent-assembly-2.svg").read_text(encoding="utf-8")
    assert f"driftform trim {shlex.quote(f'{run}:TP5')} --kit" in sheet
