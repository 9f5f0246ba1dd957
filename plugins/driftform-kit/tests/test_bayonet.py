"""A closure that opens: its lugs and tracks moved as hands move them, its O-ring against the standard, and real programs."""

import re
from pathlib import Path

import numpy as np
import pytest
from prints import chain_body, job_of

from driftform.interfaces import PrintJob
from driftform.types import State
from driftform_frusta.exporters.scad import ScadExporter
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_kit.cutting.gland import choose_gland
from driftform_kit.cutting.joint import find_seal, seal_bore
from driftform_kit.cutting.pieces import make_kit
from driftform_kit.kit import list_facts
from driftform_kit.sheet.contents import plan_sheet

INCH = 25.4
BODIES = {"fore": chain_body("uus", "nn"), "aft": chain_body("nn", "uus")}
WITH = PartOptions(kit=True, joint="bayonet", segments=96)


def open_and_shut(side):
    """The solids of plug and socket, and which way along the axis and round it the plug comes off."""
    body = BODIES[side]
    joint = make_kit(body, WITH).core_joint
    aft, fore = (part.solid.to_manifold() for part in make_parts(body, WITH))
    assert joint.kind == "bayonet" and joint.side == (1 if side == "fore" else -1)
    return (fore, aft, joint) if side == "fore" else (aft, fore, joint)


@pytest.mark.parametrize("side", ["fore", "aft"])
def test_a_closed_bayonet_holds_and_a_turn_to_the_left_opens_it(side):
    plug, socket, joint = open_and_shut(side)

    def clash(turned, pulled):
        # To the left, seen from the plug's own end, which is the one that is turned.
        moved = plug.rotate((0.0, 0.0, joint.side * turned)).translate((0.0, 0.0, joint.side * pulled))
        return (moved ^ socket).volume()

    assert clash(0.0, 0.0) < 1e-6
    assert plug.min_gap(socket, 1.0) < 1e-3  # The rims bear on each other.
    # It is held along the axis, and stops where it is closed.
    assert clash(0.0, 0.4) > 0.5 and clash(-4.0, 0.0) > 0.5
    turns = np.arange(0.0, 60.0, 0.25)
    ways = np.array([clash(turn, 0.0) for turn in turns])
    # A click: beads that are in the way by 0.15 mm, and not by more.
    free = turns[(ways < 1e-6) & (turns > 15)]
    assert 0.1 < ways[turns < free[0]].max() < 1.0
    opened = float(free.mean())
    for pulled in np.arange(0.2, joint.lap + 2, 0.4):
        assert clash(opened, pulled) < 1e-6


@pytest.mark.parametrize(
    ("cord", "depth", "width", "squeeze"),
    [
        (0.070, (0.050, 0.055), 0.105, (18, 32)),
        (0.103, (0.080, 0.086), 0.146, (14, 25)),
        (0.139, (0.110, 0.116), 0.195, (14, 23)),
    ],
)
def test_a_gland_is_that_of_the_standard_within_what_a_printer_is_off(cord, depth, width, squeeze):
    """In inches and per cent: Apple Rubber, Seal Design Guide, static seals, radial."""
    gland = choose_gland(round(INCH * cord, 2))
    assert INCH * depth[0] <= gland.depth - 0.05 and gland.depth + 0.05 <= INCH * depth[1]
    assert gland.width == pytest.approx(INCH * width, abs=0.005 * INCH)
    for bore in np.arange(12.0, 40.0, 0.37).tolist():
        found = gland.fit_ring(seal_bore(gland, bore), 0.2, 2.0)
        assert 2 * (bore - gland.depth) - 1.9 < found.groove_mm <= 2 * (bore - gland.depth)
        assert 0.0099 <= found.stretch <= 0.0501
        assert squeeze[0] < 100 * found.squeeze < squeeze[1]
        assert 0.5 < found.fill < 0.85


def test_rings_have_the_sizes_of_as568():
    for cord, known in (
        (1.78, {"AS568-012": 0.364, "AS568-020": 0.864, "AS568-030": 1.614, "AS568-040": 2.864}),
        (2.62, {"AS568-110": 0.362, "AS568-120": 0.987}),
        (3.53, {"AS568-210": 0.734, "AS568-222": 1.484, "AS568-230": 2.484}),
    ):
        for name, inside in known.items():
            gland = choose_gland(cord)
            found = gland.fit_ring(1.03 * INCH * inside / 2 + gland.depth, 0.2, 2.0)
            assert (found.ring, found.inside_mm) == (name, pytest.approx(INCH * inside, abs=0.011))


@pytest.mark.parametrize("side", ["fore", "aft"])
def test_the_groove_is_cut_as_it_is_stated(side):
    plug, socket, joint = open_and_shut(side)
    kit = make_kit(BODIES[side], WITH)
    seal = find_seal(kit.hull, joint)
    lift = joint.z - 1e3 * BODIES[side].outer[0, 0]
    at = lift - joint.side * 2.6
    outward = sorted(float(np.hypot(*ring.T).mean()) for ring in plug.slice(at).to_polygons())
    assert 2 * outward[-1] == pytest.approx(seal.groove_mm, rel=2e-3)
    assert outward[-1] - outward[-2] == pytest.approx(seal.wall_mm, abs=0.02) and seal.wall_mm > 0.8
    bore = min(np.hypot(*ring.T).mean() for ring in socket.slice(at).to_polygons())
    assert bore - seal.groove_mm / 2 == pytest.approx(seal.cord_mm * 0.749, abs=0.02)


def test_facts_and_sheet_have_the_ring_and_how_it_is_opened():
    body = BODIES["fore"]
    seal = list_facts(job_of(body), WITH)["kit"]["seal"]
    sheet = plan_sheet(job_of(body), WITH)
    text = " ".join(sheet.steps)
    assert f"{seal['ring']} of nitrile, {seal['inside_mm']:g} x 1.78\u00a0mm" in dict(sheet.shopping)["O-rings"]
    assert (
        f"squeezed by {100 * seal['squeeze']:.0f}\u00a0%" in text and f"fills {100 * seal['fill']:.0f}\u00a0%" in text
    )
    assert "turn it to the right, past a click, until it stops" in text
    assert re.search(r"To charge or to read the core, turn part 2 to the left.*put it back", text)
    assert sheet.scenes[-1] == "open 2" and "coat" not in text


def test_further_joints_of_a_kit_that_opens_are_glued():
    kit = make_kit(chain_body("uusssssss", "nn"), WITH.model_copy(update={"bed": (0.2, 0.2, 0.06)}))
    assert [joint.kind == "bayonet" for joint in kit.joints] == [joint is kit.core_joint for joint in kit.joints]
    assert len(kit.joints) > 1 and all(joint.gland is None for joint in kit.joints if joint is not kit.core_joint)


@pytest.mark.peers
def test_real_programs_take_a_kit_that_opens(ask, tmp_path):
    import lib3mf

    body = BODIES["fore"]
    volume = sum(part.solid.volume for part in make_parts(body, WITH))
    plates = ThreeMfExporter(WITH).write(job_of(body), tmp_path / "agent.3mf")
    paths = tuple(Path(file.path) for file in plates if file.path.endswith(".3mf"))
    for checker in ("prusa-slicer", "admesh"):
        found = ask(checker, PrintJob(paths))
        assert found and all(finding.state is State.PASS for finding in found.values()), found
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(paths[0]))
    assert reader.GetWarningCount() == 0
    source = ScadExporter(WITH).write(job_of(body), tmp_path / "agent.scad")[0]
    rendered = ask("openscad", PrintJob(paths, volume=1e-9 * volume, source=Path(source.path)))
    assert all(finding.state is State.PASS for finding in rendered.values()), rendered
