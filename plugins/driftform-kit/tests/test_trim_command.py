"""``driftform trim``: what is told is what then flies, and what makes no sense is refused."""

import json
import re
import shlex
import zipfile
from pathlib import Path

import pytest

from driftform_kit.kit import KitReport

pytestmark = pytest.mark.usefixtures("ideal_water")


WORD = "addF-tiltp-2-L-moveF-addF-tiltn-1-L-moveF-addB-tiltn-2-L-moveB-addB-tiltp-2-L-moveB"
NEUTRAL = ("--set", "builder.core_mass=0.02507")
"""With this core it weighs about what it displaces: it flies far before it touches a wall."""


def told(done, *arguments):
    return done("trim", WORD, *NEUTRAL, *arguments, "--simulator", "native", "--json")


def simulated(done, *arguments):
    return done("simulate", WORD, *NEUTRAL, *arguments, "--simulator", "native", "--json")["fitness"]


def test_a_light_print_is_trimmed_to_fly_as_simulated(done):
    facts = told(done, "--printed-mass", 0.0305)
    assert facts["ballast_mass"] == pytest.approx(facts["simulated_mass"] - 0.0305)
    moment = facts["simulated_mass"] * facts["simulated_cog"] - 0.0305 * facts["printed_cog"]
    assert facts["ballast_x"] == pytest.approx(moment / facts["ballast_mass"])
    assert facts["simulated"] == pytest.approx(simulated(done), abs=1e-9)
    # The ball is not where the material was, so that the inertia is another.
    assert facts["trimmed"] == pytest.approx(facts["simulated"], abs=0.2)
    off = {
        name: max(abs(facts[name][t] - f) for t, f in facts["simulated"].items()) for name in ("trimmed", "untrimmed")
    }
    assert off["untrimmed"] > 50 * off["trimmed"]
    assert sum(piece["mass"] for piece in facts["pieces"]) == pytest.approx(facts["ballast_mass"])
    assert facts["residual_moment"] == pytest.approx(0, abs=1e-9)
    assert facts["buoyancy"] is None and facts["cog_source"] == "hull"


def test_untrimmed_it_flies_as_a_hull_of_that_density(done):
    # Flights that bounce for longer may not converge.
    short = ("--set", "flow.speed=2.0")
    facts = told(done, *short, "--printed-mass", 0.0325)
    hull = facts["simulated_mass"] - 0.02507
    density = 1050.0 * (0.0325 - 0.02507) / hull
    other = simulated(done, *short, "--set", f"builder.hull_density={density!r}")
    # 0.2 mm of some 8 m: after a wall, rounding grows to that.
    assert facts["untrimmed"] == pytest.approx(other, abs=2e-3)


def test_a_heavy_print_is_told_how_much_lighter_it_has_to_be(done):
    facts = told(done, "--printed-mass", 0.0325)
    excess = 0.0325 - facts["simulated_mass"]
    assert facts["ballast_mass"] == pytest.approx(-excess)
    assert facts["pieces"] == [] and facts["residual_moment"] is None
    # Foam carries what it displaces less its own weight.
    foam = facts["buoyancy"]
    assert foam["volume"] * (1024.0 - foam["density"]) == pytest.approx(excess, rel=0.03)
    assert foam["hull_excess"] == pytest.approx(excess / (0.0325 - 0.02507))
    text = done("trim", WORD, *NEUTRAL, "--printed-mass", 0.0325, "--simulator", "native")
    assert "too heavy by" in text and "cm3 of foam" in text


def test_what_balances_elsewhere_by_too_much_is_told_by_how_much_it_stays_off(done):
    facts = told(done, "--printed-mass", 0.0312, "--printed-cog", 0.004)
    aft = facts["aft_end"]
    assert facts["ballast_x"] < aft
    [piece] = facts["pieces"]
    assert aft < piece["start"] < piece["end"]
    off = facts["ballast_mass"] * (piece["x"] - facts["ballast_x"])
    assert facts["residual_moment"] == pytest.approx(off, rel=1e-6)
    text = done("trim", WORD, *NEUTRAL, "--printed-mass", 0.0312, "--printed-cog", 0.004, "--simulator", "native")
    assert "it cannot lie there" in text


def test_a_flight_that_fails_costs_its_marks_and_not_the_command(done):
    limits = ("--set", "simulator.step_limit=40", "--simulator", "native")
    result = done("trim", WORD, *NEUTRAL, "--printed-mass", 0.0305, *limits)
    ends = [line for line in result.splitlines() if line.startswith(("simulated ", "untrimmed "))]
    assert any("failed: step limit" in line for line in ends)
    facts = told(done, "--printed-mass", 0.0305, *limits)
    assert facts["simulated"] is None
    assert facts["ends"]["simulated"]["failed"]


@pytest.mark.long
def test_ballast_of_a_kit_is_held_by_a_seat_that_the_kit_can_print(done, tmp_path):
    facts = told(done, "--kit", "--printed-mass", 0.0292)
    [piece], [ball] = facts["pieces"], facts["held"]
    assert (ball["x"], ball["diameter"]) == pytest.approx((piece["x"], piece["diameter"]), abs=2e-5)
    assert ball["held_by"] == "seat" and ball["part"] == "fore shell"
    # The seat weighs something itself: print, seat and ball weigh and balance as simulated.
    assert facts["seat_mass"] > 1e-4
    whole = 0.0292 + facts["seat_mass"] + piece["mass"]
    assert whole == pytest.approx(facts["simulated_mass"], abs=2e-6)
    assert facts["residual_moment"] == pytest.approx(0, abs=5e-5 * piece["mass"])
    assert facts["trimmed"] == pytest.approx(facts["simulated"], abs=0.3)
    # The option that is printed makes that kit ...
    text = done("trim", WORD, *NEUTRAL, "--kit", "--printed-mass", 0.0292, "--simulator", "native")
    option = re.search(r"--option '(ballast=\S+)'", text)[1]
    assert f"a steel ball of {1000 * piece['diameter']:.1f} mm" in text
    made = f"{WORD} {' '.join(NEUTRAL)} --kit --option '{option}'"
    assert f"driftform export {made}\n" in text
    assert f"driftform trim {made} --printed-mass KG --simulator native\n" in text
    command = ("export", WORD, *NEUTRAL, "--kit", "--option", option, "--format", "stl", "--out", "kit", "--json")
    kit = next(file["kit"] for file in done(*command)["files"] if "kit" in file)
    assert kit["ballast"][0]["part"] == "fore shell"
    # ... and weighed again it takes the same ball.
    weighed = 0.0292 + facts["seat_mass"]
    again = told(done, "--kit", "--printed-mass", weighed, "--set", f"exporter.stl.{option}")
    assert again["seat_mass"] == 0
    assert again["pieces"][0]["diameter"] == pytest.approx(piece["diameter"], abs=2e-5)
    assert again["residual_moment"] == pytest.approx(0, abs=5e-5 * piece["mass"])


def test_the_last_gram_lies_on_the_seat_that_is_there_and_the_rest_is_told(done):
    diameter = (6 * 0.002185 / (3.14159 * 7850)) ** (1 / 3)
    seat = ("--set", f"exporter.stl.ballast=[[0.02,{diameter:.5f}]]")
    facts = told(done, "--kit", "--printed-mass", 0.0292, *seat)
    assert facts["misfits"] == [] and facts["held"][0]["diameter"] == pytest.approx(diameter, abs=1e-5)
    assert [piece["x"] for piece in facts["pieces"]] == [0.02]
    assert facts["residual_moment"] == pytest.approx(facts["ballast_mass"] * (0.02 - facts["ballast_x"]), rel=1e-6)
    text = done("trim", WORD, *NEUTRAL, "--kit", "--printed-mass", 0.0292, *seat, "--simulator", "native")
    assert "its moment is then off by" in text


@pytest.mark.long
def test_a_seat_holds_only_a_ball_that_fits_it_else_the_seat_to_print_is_told(done):
    seat = ("--set", "exporter.stl.ballast=[[0.02,0.002]]")
    facts = told(done, "--kit", "--printed-mass", 0.0292, *seat)
    [old], [ball], [piece] = facts["misfits"], facts["held"], facts["pieces"]
    assert old["diameter"] == pytest.approx(0.002)
    assert (ball["x"], ball["diameter"]) == pytest.approx((piece["x"], piece["diameter"]), abs=2e-5)
    # The seat that is replaced was weighed with the print: what the other one weighs more is counted.
    whole = 0.0292 + facts["seat_mass"] + piece["mass"]
    assert whole == pytest.approx(facts["simulated_mass"], abs=2e-6)
    text = done("trim", WORD, *NEUTRAL, "--kit", "--printed-mass", 0.0292, *seat, "--simulator", "native")
    assert "is for a ball of 2.0 mm, and does not hold this ballast" in text
    assert f"--option 'ballast=[[{ball['x']:.5g},{ball['diameter']:.5g}]]'" in text


NECK = "-".join(["addF-tiltn-2-L-moveF"] * 3 + ["addF-tiltp-2-L-moveF"] * 3 + ["addF-tiltp-0-L-moveF"])


@pytest.mark.long
def test_a_ball_that_was_printed_in_is_taken_off_what_is_weighed(done):
    fast = ("--simulator", "native")
    whole = done("trim", NECK, "--printed-mass", "0.06", *fast, "--json")
    mass, cog = whole["simulated_mass"], whole["simulated_cog"]
    lack, beyond_the_neck = 0.001, 0.06
    balance = (mass * cog - lack * beyond_the_neck) / (mass - lack)
    given = ("--kit", "--printed-mass", mass - lack, "--printed-cog", balance, *fast)
    facts = done("trim", NECK, *given, "--json")
    [ball], [piece] = facts["held"], facts["pieces"]
    assert ball["pause"] is not None
    text = done("trim", NECK, *given)
    assert f"weigh it, take off the {1000 * piece['mass']:.3f} g of ballast that is inside" in text
    assert "without the ball" not in text


@pytest.mark.long
def test_the_commands_to_copy_carry_what_the_user_gave(done):
    given = (
        *("--kit", "--format", "3mf,stl", "--bed", "220,200,45", "--option", "lap=0.007"),
        *("--option", "joint=rabbet", "--ballast-density", "11340"),
    )
    text = done("trim", WORD, *NEUTRAL, *given, "--printed-mass", 0.0292, "--simulator", "native")
    export, trim = (shlex.split(line) for line in text.splitlines() if line.startswith("  driftform"))
    assert export[:2] == ["driftform", "export"] and trim[:2] == ["driftform", "trim"]
    assert trim[2:] == [*export[2:], "--printed-mass", "KG", "--simulator", "native"]
    written = done(*export[1:], "--out", "kit", "--json")["files"]
    assert {file["format"] for file in written} == {"3mf", "stl"}
    with zipfile.ZipFile(next(file["path"] for file in written if file["format"] == "3mf")) as archive:
        options = json.loads(archive.read("Metadata/kit.json"))
    assert options["bed"] == [0.22, 0.2, 0.045] and options["ballast_density"] == 11340
    assert (options["lap"], options["joint"], len(options["ballast"])) == (0.007, "rabbet", 1)
    # The sheet of that kit has the command to trim it, for the format that it was written with.
    sheet = next(Path("kit").glob("*-assembly-2.svg")).read_text(encoding="utf-8")
    assert "lead ball" in done(*(word if word != "KG" else "0.0293" for word in trim[1:]))
    for word in ("--bed 220,200,45", "joint=rabbet", "ballast_density=11340", "builder.core_mass=0.02507"):
        assert word in sheet


@pytest.fixture
def kit_of_34_grams(monkeypatch):
    """A kit that weighs 34 g with the core, balances 5 mm fore of its centre, and holds no ballast."""
    monkeypatch.setattr("driftform_kit.trim.report_kit", lambda body, options: KitReport(0.034, 0.005))


@pytest.mark.usefixtures("kit_of_34_grams")
def test_a_kit_that_holds_no_ballast_is_trimmed_with_putty(done):
    facts = told(done, "--kit", "--printed-mass", 0.0292)
    assert facts["held"] == [] and facts["seat_mass"] == 0
    assert facts["unheld"] and [piece["putty"] for piece in facts["pieces"]] == [pytest.approx(facts["ballast_mass"])]
    assert facts["trimmed"] is not None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--printed-mass", "71.2"), "is in kg"),
        (("--printed-mass", "0.05"), "with its core in"),
        (("--printed-mass", "nan"), "with its core in"),
        (("--printed-mass", "0.056", "--printed-cog", "12"), "lies outside the body"),
        (("--printed-mass", "0.0501", "--printed-cog", "0.02"), "the hull alone would balance"),
        (("--printed-mass", "0.055", "--ballast-density", "0"), "--ballast-density 0"),
        (("--printed-mass", "0.055", "--ballast-density", "900"), "must be more than that of the water"),
        (("--printed-mass", "0.06", "--bed", "9,9,9"), "--bed: goes with --kit"),
        ((), "--printed-mass is missing"),
        (("--kit", "--printed-cog", "0.001"), "--printed-mass is missing"),
    ],
)
def test_what_makes_no_sense_is_refused(refused, arguments, message):
    assert message in refused("trim", WORD, *arguments, "--simulator", "native")
