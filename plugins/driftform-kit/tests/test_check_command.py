"""``driftform check``: agents and files, exit codes, and what it knows of whose file it is."""

import json
import shutil
from pathlib import Path

import pytest
import trimesh
from prints import edit_archive, mesh_xml, write_3mf

WORD = "addB-tiltn-1-M-moveB-addB-tiltp-1-L-moveB"
OTHER = "addB-tiltn-1-M-moveB"


def lines(result):
    document = json.loads(result.stdout)
    assert document["printable"] is (result.exit_code == 0)
    return {line["check"]: line for line in document["lines"]}


def exported(done, format="stl"):
    return Path(done("export", WORD, "--format", format, "--json")["files"][0]["path"])


def agent_file(done, word, path):
    """The agent of a word as an agent.json."""
    if not Path("sampled").exists():
        done("sample", "--count", 1, "--out", "sampled")
    document = json.loads(Path("sampled/agent-0001.json").read_text())
    document["genome"]["symbols"] = ["C", *word.split("-")] if not word.startswith("C") else word.split("-")
    path.write_text(json.dumps(document))
    return path


def test_a_sound_agent_is_printable(call, tmp_path):
    result = call("check", WORD, "--no-programs", "--json")
    assert result.exit_code == 0, result.stderr
    found = lines(result)
    assert found["mass"]["state"] == found["shells"]["state"] == found["wall"]["state"] == "pass"
    assert "6.0 lines of 0.4 mm" in found["wall"]["detail"]
    slicer = {"check": "prusa-slicer", "part": "", "state": "skipped", "detail": "not run, by --no-programs"}
    assert found["prusa-slicer"] == slicer
    assert list(tmp_path.iterdir()) == []


def test_a_line_that_fails_is_exit_code_1_and_named_in_the_verdict(call):
    result = call("check", WORD, "--no-programs", "--bed", "10,10,10", "--nozzle", "2")
    assert result.exit_code == 1
    verdict = result.stdout.splitlines()[-1]
    assert verdict.startswith("not printable as it is, for bed: ") and "1 fail" in verdict
    shouted = [line for line in result.stdout.splitlines() if line.startswith("FAIL")]
    assert len(shouted) == 1 and "bed" in shouted[0]
    assert any(line.startswith("warn") and "lines of the 2 mm nozzle" in line for line in result.stdout.splitlines())
    assert "\x1b" not in result.stdout


@pytest.mark.long
def test_a_file_has_no_mass_to_compare_with_until_its_agent_is_named(call, done):
    path = exported(done)
    assert lines(call("check", path, "--no-programs", "--json"))["mass"]["state"] == "skipped"
    named = lines(call("check", path, "--agent", WORD, "--no-programs", "--json"))
    assert named["mass"]["state"] == "pass"
    wrong = call("check", path, "--agent", OTHER, "--no-programs", "--json")
    assert wrong.exit_code == 1
    assert [check for check, line in lines(wrong).items() if line["state"] == "fail"] == ["mass"]


def test_the_agent_beside_a_file_is_its_own(call, done):
    path = exported(done)
    agent_file(done, WORD, path.with_name("agent.json"))
    assert lines(call("check", path, "--no-programs", "--json"))["mass"]["state"] == "pass"
    agent_file(done, OTHER, path.with_name("agent.json"))
    assert call("check", path, "--no-programs").exit_code == 1


def test_the_agent_attached_to_a_3mf_comes_before_the_one_beside_it(call, done, tmp_path):
    own = {"Metadata/agent.json": agent_file(done, WORD, tmp_path / "own.json").read_text()}
    mesh = trimesh.load_mesh(exported(done))
    path = write_3mf(
        tmp_path / "hull.3mf", f'<object id="1">{mesh_xml(mesh.vertices, mesh.faces)}</object>', attached=own
    )
    agent_file(done, OTHER, tmp_path / "agent.json")
    assert lines(call("check", path, "--no-programs", "--json"))["mass"]["state"] == "pass"


@pytest.mark.parametrize("harm", ["content", "method", "encrypted"])
def test_an_archive_that_cannot_be_read_is_refused_in_one_line(refused, tmp_path, harm):
    path = write_3mf(tmp_path / "broken.3mf", attached={"Metadata/agent.json": "cube(10);"})
    data = bytearray(path.read_bytes())
    central, local = data.rindex(b"Metadata/agent.json") - 46, data.index(b"Metadata/agent.json") - 30
    if harm == "content":
        data[data.index(b"cube(10);") + 3] ^= 0xFF
    elif harm == "method":
        data[central + 10] = data[local + 8] = 99
    else:
        data[central + 8] |= 1
        data[local + 6] |= 1
    path.write_bytes(bytes(data))
    line = refused("check", "broken.3mf", "--no-programs")
    assert line.startswith("error: broken.3mf: cannot be read as an archive: ")


@pytest.mark.peers
def test_openscad_renders_the_source_of_an_agent(call):
    if shutil.which("openscad") is None:
        pytest.skip("openscad is not installed")
    found = lines(call("check", WORD, "--set", "checker.prusa-slicer.timeout=0.001", "--json"))
    assert found["openscad"]["state"] == "pass" and "the source renders to" in found["openscad"]["detail"]
    assert found["admesh"]["state"] == ("pass" if shutil.which("admesh") else "skipped")
    # Options of a checker are those of its table: this one gave up at once, and says so.
    assert any("did not end within 0.001 s" in line["detail"] for line in found.values()) or (
        found["prusa-slicer mesh"]["detail"] == "prusa-slicer is not on PATH"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("hull.stl",), "AGENT 'hull.stl'"),
        ((WORD, "--format", "slt"), "--format slt: no exporter is named 'slt'; did you mean 'stl'?"),
        ((WORD, "--bed", "250"), "--bed 250: should be three lengths in mm, such as 250,210,210"),
        ((WORD, "--bed", "1,2,-3"), "above 0"),
        ((WORD, "--bed", "1,2,nan"), "above 0"),
        ((WORD, "--nozzle", "0"), "--nozzle 0"),
        ((WORD, "--agent", OTHER), "goes with a FILE"),
        ((WORD, "--set", "checker.mesh.tolerence=1"), "did you mean 'tolerance'?"),
        ((WORD, "--set", "checker.mash.tolerance=1"), "did you mean 'mesh'?"),
    ],
)
def test_what_makes_no_sense_is_refused(refused, arguments, message):
    assert message in refused("check", *arguments)


@pytest.mark.parametrize("name", ["note.txt", "empty.stl", "archive.3mf"])
def test_a_file_that_is_none_to_print_is_refused(refused, tmp_path, name):
    (tmp_path / name).write_bytes(b"")
    assert name in refused("check", name)


def test_without_any_checker_nothing_is_called_printable(call, monkeypatch):
    from driftform.plugins.registry import Registry

    seam = Registry.seam
    monkeypatch.setattr(Registry, "seam", lambda self, name: [] if name == "checker" else seam(self, name))
    result = call("check", WORD)
    assert result.exit_code == 1
    assert "no checker is installed" in result.stderr and "printable" not in result.stdout


LONG = "-".join(["addF-tiltp-0-L-moveF"] * 5 + ["addB-tiltn-1-L-moveB"] * 3)


def exported_kit(done, *options):
    arguments = [part for option in options for part in ("--option", option)]
    plain = ("--set", "builder.pockets.diameter=0")
    return Path(done("export", LONG, *plain, "--kit", "--format", "3mf", *arguments, "--json")["files"][0]["path"])


def test_a_3mf_of_a_kit_is_checked_with_the_options_and_for_the_printer_that_it_was_made_for(call, done):
    made = ("ballast=[[0.04,0.006]]", "lap=0.007", "bed=[0.2,0.2,0.26]", "nozzle=0.0005")
    path = exported_kit(done, *made)
    result = call("check", path, "--no-programs", "--json")
    assert result.exit_code == 0, result.stdout + result.stderr
    found = lines(result)
    assert found["mass"]["state"] == "pass"
    assert "fits 200 x 200 x 260 mm" in found["bed"]["detail"] and "0.5 mm" in found["wall"]["detail"]
    # Options of the command line come before those of the file.
    given = ("--bed", "90,90,30", "--set", "exporter.3mf.sleeve=0.003")
    other = lines(call("check", path, "--no-programs", "--json", *given))
    assert other["bed"]["state"] == other["mass"]["state"] == "fail"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"{", "is not JSON in UTF-8"),
        (b"[" * 100_000, "is nested too deeply"),
        (b"[1]", "it is not a table"),
        (b'{"kit": 1e999}', "'kit'"),
        (b'{"ballast": [[0, 0.01], [0, 0.01], [0, 0.01]]}', "'ballast'"),
        (b'{"kit\\u001b[2J": true}', "x1b[2J'"),
    ],
)
def test_options_of_a_kit_in_a_file_of_a_stranger_are_refused_in_one_line(done, refused, data, message):
    path = exported_kit(done)
    edit_archive(path, {"Metadata/kit.json": data})
    line = refused("check", path, "--no-programs")
    assert line.startswith(f"error: {path}: its kit.json: ") and message in line
    assert line.isprintable() and len(line) < 300


def test_a_file_of_a_kit_that_is_checked_as_a_hull_is_told_to_be_one(call, done):
    word = "addF-tiltp-0-L-moveF-addF-tiltp-0-L-moveF-addF-tiltp-0-L-moveF-addB-tiltn-1-L-moveB"
    # A lap of 2 mm adds so little that it could be mistaken for the chords of a coarse mesh.
    little = ("--option", "lap=0.002", "--option", "sleeve=0.0004")
    path = Path(done("export", word, "--kit", "--format", "3mf", *little, "--json")["files"][0]["path"])
    edit_archive(path, removed=["Metadata/kit.json"])  # as other programs save it
    coarse = ("--set", "checker.mesh.coarse=0.2")
    found = lines(call("check", path, "--no-programs", "--json", *coarse))["mass"]
    assert found["state"] == "warn" and "check it with --kit" in found["detail"]
    assert "segments" not in found["detail"]
