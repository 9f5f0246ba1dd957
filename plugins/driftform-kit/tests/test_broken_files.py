"""Files broken in a known way, made of a real export: the right line fails, and no other line lies about it."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from prints import mesh_xml, write_3mf

from driftform.design.opening import open_agent
from driftform.interfaces import Printer, PrintJob
from driftform.types import State
from driftform_frusta.hull import hull_volume

LINES = ["unit", "duplicate faces", "closed", "oriented", "shells", "mass", "wall", "bed", "standing", "slender"]


def states(found):
    # What the hull withstands is a line about the agent, not about its file.
    of_file = {check: str(finding.state) for check, finding in found.items() if check != "pressure"}
    assert list(of_file) == LINES
    return of_file


def known(opened):
    return {"export": opened.export_job(), "volume": hull_volume(opened.agent.body)}


def alone(*failed, skipped=(), warned=("standing",)):
    """States where these lines are as told, and every other one passes."""
    told = dict.fromkeys(LINES, "pass")
    told |= dict.fromkeys(warned, "warn") | dict.fromkeys(skipped, "skipped") | dict.fromkeys(failed, "fail")
    return told


def test_the_sound_file_passes(check_mesh, sound, opened):
    found = check_mesh(sound, **known(opened))
    assert states(found) == alone()
    assert "better fore end down" in found["standing"].detail


NO_INSIDE = ("shells", "mass", "wall", "standing", "slender")


def lose_faces(vertices, faces, outside, hollow):
    # Two that share no vertex: two holes of three edges each.
    other = int(np.flatnonzero(~np.isin(faces, faces[0]).any(axis=1))[-1])
    return vertices, np.delete(faces, [0, other], axis=0)


def flip_faces(vertices, faces, outside, hollow):
    flipped = faces.copy()
    flipped[[10, 500, 3000]] = faces[[10, 500, 3000], ::-1]
    return vertices, flipped


BREAKS = {
    "missing faces": (
        lose_faces,
        alone("closed", skipped=NO_INSIDE, warned=()),
        "closed",
        "6 open edges round 2 holes",
    ),
    "flipped faces": (flip_faces, alone("oriented", skipped=NO_INSIDE, warned=()), "oriented", "3 faces "),
    "everything inverted": (
        lambda v, f, o, h: (v, f[:, ::-1]),
        alone("shells", skipped=("mass",)),
        "shells",
        "everything is inside out",
    ),
    "cavity inside out": (
        lambda v, f, o, h: (v, np.concatenate((o, h[:, ::-1]))),
        alone("shells", skipped=("mass",)),
        "shells",
        "1 hollow inside out",
    ),
    "metres instead of millimetres": (
        lambda v, f, o, h: (v / 1000, f),
        alone("unit", skipped=("mass", "wall", "bed", "standing", "slender"), warned=()),
        "unit",
        "in metres? scale it by 1000",
    ),
    # Once as they are, and once turned round: both are copies.
    "duplicate faces": (
        lambda v, f, o, h: (v, np.concatenate((f, f[:5], f[7:9, ::-1]))),
        alone("duplicate faces"),
        "duplicate faces",
        "7 triangles twice",
    ),
}


@pytest.mark.parametrize("agent_known", [True, False])
@pytest.mark.parametrize("fault", BREAKS)
def test_each_fault_fails_its_own_line(check_mesh, mesh, shells, written, opened, fault, agent_known):
    spoil, expected, line, words = BREAKS[fault]
    found = check_mesh(written(*spoil(mesh.vertices, mesh.faces, *shells)), **(known(opened) if agent_known else {}))
    # A mass is compared only with that of a known agent.
    assert states(found) == expected | ({} if agent_known else {"mass": "skipped"})
    assert words in found[line].detail
    # Walls are where they were: the material lies between the shells, whichever way they face.
    assert line != "shells" or found["wall"].detail.startswith("1.2")


def test_a_hollow_that_is_left_out(check_mesh, mesh, shells, written, opened):
    path = written(mesh.vertices, shells[0])
    assert states(check_mesh(path, **known(opened))) == alone("shells", "mass")
    # A solid body is a sound print of something else.
    assert "fail" not in states(check_mesh(path)).values()


def test_millimetres_in_a_format_of_metres(check_mesh, mesh, written):
    found = check_mesh(written(mesh.vertices, mesh.faces, "broken.glb"))
    assert [check for check, finding in found.items() if finding.state is State.FAIL] == ["unit"]
    assert "0.001" in found["unit"].detail


@pytest.mark.long
def test_a_wall_of_a_fifth_of_a_millimetre(check_mesh, tmp_path):
    thin = open_agent("C", "paper", settings=["builder.wall=0.0002"])
    path = tmp_path / "thin.stl"
    thin.study.make_exporter("stl").write(thin.export_job(), path)
    found = check_mesh(path, **known(thin))
    assert states(found) == alone("wall")
    assert found["wall"].detail.startswith("0.2") or found["wall"].detail.startswith("0.19")
    # A nozzle of half that width prints it.
    assert check_mesh(path, Printer(nozzle=0.0001))["wall"].state is State.WARN


def test_too_tall_for_the_bed(check_mesh, sound, opened):
    found = check_mesh(sound, Printer(bed=(0.25, 0.21, 0.05)), **known(opened))
    assert states(found) == alone("bed", warned=("standing", "slender"))
    assert "too tall" in found["bed"].detail and "it would fit lying" in found["bed"].detail
    small = check_mesh(sound, Printer(bed=(0.03, 0.03, 0.21)))["bed"]
    assert small.state is State.FAIL and "too wide" in small.detail and "--kit" in small.detail


def test_a_surface_that_three_faces_meet_in(check_mesh, mesh, written):
    # A fin on one edge: a triangle with a vertex of its own.
    a, b, _ = mesh.faces[100]
    vertices = np.vstack((mesh.vertices, mesh.vertices[a] + [0, 0, 70.0]))
    found = check_mesh(written(vertices, np.vstack((mesh.faces, [a, b, len(mesh.vertices)]))))
    assert found["closed"].state is State.FAIL
    assert "1 edge of three faces or more" in found["closed"].detail
    assert "2 open edges" in found["closed"].detail


def test_shells_that_pass_through_one_another(check_mesh, written):
    one = trimesh.creation.box((20, 20, 20))
    other = trimesh.creation.icosphere(subdivisions=3, radius=6)
    other.apply_translation((10, 3, 2))
    both = trimesh.util.concatenate([one, other])
    found = check_mesh(written(both.vertices, both.faces))
    assert found["shells"].state is State.FAIL and "intersect" in found["shells"].detail


def test_parts_that_overlap_on_a_plate_fail_by_their_names(check_mesh, tmp_path):
    block = trimesh.creation.box((20, 20, 20))
    objects = "".join(
        f'<object id="{n}" name="block {n}">{mesh_xml(block.vertices, block.faces)}</object>' for n in "12"
    )
    for shift, state in ((25, State.PASS), (20, State.PASS), (15, State.FAIL), (0, State.FAIL)):
        items = f'<item objectid="1"/><item objectid="2" transform="1 0 0 0 1 0 0 0 1 {shift} 0 0"/>'
        found = check_mesh(write_3mf(tmp_path / f"{shift}.3mf", objects, items))["overlap"]
        assert found.state is state
        assert state is State.PASS or f"block 1 and block 2 by {8 - 0.4 * shift:g} cm3" in found.detail


def test_parts_of_a_kit_stand_as_check_would_place_them(check_mesh, tmp_path):
    # Its aft shell overhangs less with its fore end on the bed, but would come off it.
    design = open_agent(
        "C: addF-tiltp-0-M-moveB-addF-tiltn-2-L-moveB-addB-tiltp-0-L-moveB | "
        "S: addF-tiltp-0-L-moveF-addF-tiltn-2-L-moveN-addB-tiltn-0-S-moveN | "
        "M: addB-tiltp-2-S-moveN-addB-tiltp-1-S-moveB-addB-tiltn-2-S-moveN | "
        "L: addB-tiltp-0-M-moveF-addB-tiltp-2-L-moveB-addB-tiltp-2-L-moveF",
        "pipe-inspection",
        settings=["exporter.3mf.kit=true"],
    )
    path, *_ = (Path(file.path) for file in design.export_files("3mf", tmp_path / "kit.3mf"))
    standing = {check: one.detail for check, one in check_mesh(path).items() if check.startswith("standing")}
    assert len(standing) > 1 and not [detail for detail in standing.values() if "better upside down" in detail]


def test_a_loose_piece_in_a_hollow_faces_outward(check_mesh, written):
    outer, hollow, piece = (trimesh.creation.icosphere(subdivisions=3, radius=r) for r in (30, 20, 10))
    hollow.invert()
    for turned, state in ((False, State.WARN), (True, State.FAIL)):
        if turned:
            piece.invert()
        whole = trimesh.util.concatenate([outer, hollow, piece])
        assert check_mesh(written(whole.vertices, whole.faces))["shells"].state is state


def test_another_agent_s_file_does_not_have_this_one_s_mass(check_mesh, sound):
    other = open_agent("addB-tiltn-1-M-moveB", "paper")
    found = check_mesh(sound, **known(other))
    assert states(found) == alone("mass")


def test_a_coarse_mesh_is_a_warning(check_mesh, opened, tmp_path):
    body = opened.agent.body
    path = tmp_path / "coarse.stl"
    outside, hollow = (trimesh.creation.revolve(1000 * c[:, ::-1], sections=64) for c in (body.outer, body.cavity))
    hollow.invert()
    trimesh.util.concatenate([outside, hollow]).export(path)
    found = check_mesh(path, **known(opened))
    assert found["mass"].state is State.WARN and "-1.6e-03" in found["mass"].detail


def test_programs_fail_the_file_with_missing_faces_too(ask, mesh, written):
    job = PrintJob((written(mesh.vertices, mesh.faces[5:]),))
    assert ask("admesh", job)["admesh"].state is State.FAIL
    found = ask("prusa-slicer", job)
    assert found["prusa-slicer mesh"].state is State.FAIL
    assert found["prusa-slicer g-code"].state is State.SKIPPED
