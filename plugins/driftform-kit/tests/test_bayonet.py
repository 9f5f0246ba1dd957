"""A closure that opens: its lugs and tracks moved as hands move them, its O-ring against the standard, and real programs."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from manifold3d import Manifold
from prints import chain_body, job_of

from driftform.agent import mass_properties
from driftform.interfaces import PrintJob
from driftform.types import Module, Moments, Morphology, State
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.exporters.scad import ScadExporter
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_kit.cutting.gland import choose_gland
from driftform_kit.cutting.joint import find_seal, seal_bore
from driftform_kit.cutting.pieces import make_kit
from driftform_kit.cutting.thread import PITCH
from driftform_kit.kit import list_facts
from driftform_kit.sheet.contents import plan_sheet

INCH = 25.4
BODIES = {"fore": chain_body("uuss", "nn"), "aft": chain_body("nn", "uuss")}
WITH = PartOptions(kit=True, joint="bayonet", segments=96)


def open_and_shut(side, kind="bayonet"):
    """The solids of plug and socket, and their joint: the plug comes off to its own side."""
    body, options = BODIES[side], WITH.model_copy(update={"joint": kind})
    joint = make_kit(body, options).core_joint
    aft, fore = (part.solid.to_manifold() for part in make_parts(body, options))
    assert joint.kind == kind and joint.side == (1 if side == "fore" else -1)
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


@pytest.mark.parametrize("side", ["fore", "aft"])
def test_a_thread_goes_on_in_two_turns_to_the_right_and_stops_where_the_rims_meet(side):
    plug, socket, joint = open_and_shut(side, "thread")

    def clash(turned, pulled):
        moved = plug.rotate((0.0, 0.0, joint.side * turned)).translate((0.0, 0.0, joint.side * pulled))
        return (moved ^ socket).volume()

    assert all(clash(turned, PITCH * turned / 360) < 1e-6 for turned in range(0, 1080, 24))
    assert plug.min_gap(socket, 1.0) < 1e-3
    # It holds along the axis from a quarter of a millimetre on, by its flanks, also before it is closed, and has room to be tightened.
    assert clash(0.0, 0.2) < 1e-6 and clash(0.0, 0.5) > 5 and clash(360.0, PITCH + 0.5) > 2
    assert clash(-40.0, 0.0) < 1e-6 and clash(-75.0, 0.0) > 5
    # The other way round it does not go on.
    assert max(clash(-turned, PITCH * turned / 360) for turned in (90, 180, 270)) > 5


@pytest.mark.parametrize(("clearance", "held"), [(0.0001, True), (0.0003, True), (0.00031, False)])
def test_a_thread_has_its_clearance_all_round_and_at_least_half_of_its_ridge_holds(clearance, held):
    options = {**WITH.model_dump(), "joint": "thread", "clearance": clearance}
    if not held:
        with pytest.raises(ValueError, match="a thread holds too little"):
            PartOptions(**options)
        return
    aft, fore = (part.solid.to_manifold() for part in make_parts(BODIES["fore"], PartOptions(**options)))
    # As the coupon finds it: pulled off by twice the gap along flanks of 45 degrees they still pass, by a little more not.
    for share, passes in ((0.9, True), (1.25, False)):
        moved = fore.translate((0.0, 0.0, share * 2**0.5 * 1e3 * clearance))
        assert ((moved ^ aft).volume() < 1e-6) is passes


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
    rows = {name: mass for name, mass, _ in sheet.weights}
    assert rows["O-rings"] == seal["mass_kg"]
    assert rows["closed kit"] == pytest.approx(sum(rows.values()) - rows["closed kit"] - rows["as simulated"])


@pytest.mark.parametrize("side", ["fore", "aft"])
def test_the_o_ring_weighs_and_the_room_before_it_does_not_float(side):
    modules = [tuple(Module(0.01, tilt) for tilt in tilts) for tilts in ((0.3, 0.3, 0.0), (0.0, 0.0))]
    made = FrustaBuilder(FrustaOptions(made_as="kit", kit={"joint": "bayonet"}))
    body = made.build(Morphology(*(modules if side == "fore" else modules[::-1])))
    kit = make_kit(body, WITH)
    seal, [gland] = find_seal(kit.hull, kit.core_joint), body.fittings.glands
    # A torus of nitrile; in water it hangs on the side of the plug, where the groove is cut.
    ring = np.pi**2 / 4 * 1.78**2 * (seal.inside_mm + 1.78) * 1.25e-6
    bare = replace(body, fittings=replace(body.fittings, seals=Moments(), flooded=Moments()))
    with_ring, without = mass_properties(body), mass_properties(bare)
    assert with_ring.mass - without.mass == pytest.approx(ring, rel=1e-9) and 1e-4 < ring < 4e-4
    assert body.fittings.seals.centroid * 1e3 == pytest.approx(kit.core_joint.z - kit.core_joint.side * 2.9, abs=0.1)
    # The water before it: what the drawn parts leave free between the rims and the middle of the groove, less half the ring.
    joint, plug, socket = kit.core_joint, *(part.solid.to_manifold() for part in make_parts(body, WITH)[::-1])
    lift = joint.z - 1e3 * body.outer[0, 0]
    ends = sorted((lift, lift - joint.side * 2.9))
    tube = Manifold.cylinder(ends[1] - ends[0], seal.groove_mm / 2 + 2.0, circular_segments=96)
    room = tube.translate((0.0, 0.0, ends[0])) - plug - socket
    room -= Manifold.cylinder(200.0, seal.groove_mm / 2, circular_segments=96)
    flooded = room.volume() - ring / 1.25e-6 / 2
    assert 1e9 * (without.volume - with_ring.volume) == pytest.approx(flooded, rel=0.1) and 30 < flooded < 150
    assert gland["mass"] == pytest.approx(ring) and gland["groove"] == seal.groove_mm / 1000
    assert f"{1000 * ring:.2f} g; groove {seal.groove_mm:.2f} mm across, {seal.wall_mm:.2f} mm" in gland["summary"]


def test_further_joints_of_a_kit_that_opens_are_glued():
    kit = make_kit(chain_body("uusssssss", "nn"), WITH.model_copy(update={"bed": (0.2, 0.2, 0.06)}))
    assert [joint.kind == "bayonet" for joint in kit.joints] == [joint is kit.core_joint for joint in kit.joints]
    assert len(kit.joints) > 1 and all(joint.gland is None for joint in kit.joints if joint is not kit.core_joint)


@pytest.mark.peers
@pytest.mark.parametrize("joint", ["bayonet", "thread"])
def test_real_programs_take_a_kit_that_opens(ask, tmp_path, joint):
    import lib3mf

    body, options = BODIES["fore"], WITH.model_copy(update={"joint": joint})
    volume = sum(part.solid.volume for part in make_parts(body, options))
    plates = ThreeMfExporter(options).write(job_of(body), tmp_path / "agent.3mf")
    paths = tuple(Path(file.path) for file in plates if file.path.endswith(".3mf"))
    for checker in ("prusa-slicer", "admesh"):
        found = ask(checker, PrintJob(paths))
        assert found and all(finding.state is State.PASS for finding in found.values()), found
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(paths[0]))
    assert reader.GetWarningCount() == 0
    source = ScadExporter(options).write(job_of(body), tmp_path / "agent.scad")[0]
    rendered = ask("openscad", PrintJob(paths, volume=1e-9 * volume, source=Path(source.path)))
    assert all(finding.state is State.PASS for finding in rendered.values()), rendered
