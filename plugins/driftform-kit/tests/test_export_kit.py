"""``export --kit``: files for each part, the balance of the kit, and clear lines where there can be none."""

import shlex

import pytest
import trimesh

pytestmark = pytest.mark.usefixtures("ideal_water")

LONG = "addF-tiltp-0-L-moveF-addF-tiltp-0-L-moveF-addF-tiltp-0-L-moveF-addB-tiltn-1-L-moveB-addB-tiltn-1-L-moveB"
"""Straight ahead of the core, narrower behind it."""

WIDE = "addF-tiltp-2-L-moveF-addF-tiltp-1-L-moveF-addF-tiltp-0-L-moveF-addB-tiltn-1-L-moveB-addB-tiltn-1-L-moveB"
"""As wide fore of the core as a bayonet needs."""


def files(done, *arguments, agent=LONG):
    """What the command says of files with parts; the assembly sheets are left out."""
    found = done("export", agent, *arguments, "--json")["files"]
    return [file for file in found if "-assembly-" not in file["path"]]


def test_each_part_gets_a_file_and_each_file_tells_of_the_kit(done, tmp_path):
    aft, fore = files(done, "--kit", "--out", str(tmp_path))
    assert aft["path"].endswith("-aft-shell.stl") and fore["path"].endswith("-fore-shell.stl")
    assert aft["kit"] == fore["kit"]
    assert aft["kit"]["joint"]["kind"] == "sleeve"
    for told, part in zip((aft, fore), aft["kit"]["parts"], strict=True):
        mesh = trimesh.load_mesh(told["path"])
        assert mesh.is_watertight
        assert mesh.extents[2] == pytest.approx(part["height_mm"], rel=1e-5)
        assert 1e-9 * mesh.volume * 1050 == pytest.approx(part["mass_kg"], rel=1e-5)


def test_the_assembly_sheet_is_written_once_for_all_formats(done, tmp_path):
    out = done("export", LONG, "--kit", "--format", "stl,3mf,glb", "--out", str(tmp_path))
    pages = sorted(page.name for page in tmp_path.glob("*.svg"))
    assert [page[-15:] for page in pages] == ["-assembly-1.svg", "-assembly-2.svg"]
    assert [out.count(page) for page in pages] == [1, 1]
    done("export", LONG, "--format", "stl", "--out", str(tmp_path / "whole"))
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


def test_an_agent_simulated_with_a_bayonet_is_exported_and_trimmed_as_a_kit_with_a_bayonet(call, done, tmp_path):
    made = ("--set", "builder.made_as=kit", "--set", "builder.kit.joint=bayonet", "--kit")
    simulated, printed = files(done, *made, "--out", str(tmp_path), agent=WIDE)[0]["kit"]["balance"]
    assert printed["mass_kg"] == pytest.approx(simulated["mass_kg"], abs=1e-7)
    trimmed = done("trim", WIDE, *made, "--json")
    assert trimmed["printed_mass"] == pytest.approx(simulated["mass_kg"], abs=1e-7)
    glued = files(done, *made, "--option", "joint=auto", "--out", str(tmp_path), agent=WIDE)
    assert glued[0]["kit"]["joint"]["kind"] == "sleeve"
    result = call("export", WIDE, *made, "--option", "joint=auto", "--bed", "15,15,15", "--out", str(tmp_path))
    assert result.exit_code == 1 and "; the agent was simulated with the [builder.kit] options" in result.stderr
    assert '--option joint="bayonet"' in result.stderr and result.stderr.count("\n") == 1


def test_what_holds_parts_is_written_and_what_does_not_is_named_first(call, tmp_path):
    result = call("export", LONG, "--kit", "--format", "svg,stl", "--out", str(tmp_path))
    assert result.exit_code == 0 and result.stderr == "note: not written: svg, which holds no parts of a kit\n"
    assert len(list(tmp_path.glob("*.stl"))) == 2 and not (tmp_path / "LONG.svg").exists()


@pytest.mark.long
def test_sheets_in_the_folder_of_a_run_name_the_agent_as_commands_take_it(done, tmp_path):
    run = tmp_path / "run 2"
    formats = ("--set", 'run.formats=["stl"]', "--set", "exporter.stl.kit=true")
    few = ("--target", "TP5", "--evaluations", "8", "--seed", "4", "--workers", "1", "--robust", "0")
    done("evolve", *few, "--simulator", "native", *formats, "--out", str(run))
    sheet = (run / "best/TP5/agent-assembly-2.svg").read_text(encoding="utf-8")
    assert f"driftform trim {shlex.quote(f'{run}:TP5')} --kit" in sheet
