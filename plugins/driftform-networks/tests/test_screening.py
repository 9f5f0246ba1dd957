"""Which bodies may be used: the speed that moves one from the wall, and what the command says of a day with a still night."""

from pathlib import Path

import numpy as np
import pytest

from driftform.types import End
from driftform_networks.flights.bodies import open_traveller
from driftform_networks.flights.straight import fly, release
from driftform_networks.flights.threshold import moving_speed, rolling_resistance

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"

DAY = """
[JUNCTIONS]
 fork 10 0
 ahead 20 29 day
 narrow 10 1 day
[RESERVOIRS]
 source 60
[PIPES]
 main source fork 200 300 100 0 Open
 on fork ahead 600 300 100 0 Open
 side fork narrow 200 40 100 0 Open
[PATTERNS]
 day 1 0.05
[OPTIONS]
 Units LPS
 Headloss H-W
[TIMES]
 Duration 24
 Pattern Timestep 12
[COORDINATES]
 source 0 0
 fork 200 0
 ahead 800 0
 narrow 200 -200
[END]
"""
"""By day 0.42 m/s in a main of 300 mm and 0.8 m/s in one of 40 mm; a twentieth of that from hour 12 on."""


def test_a_sphere_rolls_from_the_speed_at_which_its_drag_lifts_it_over_the_roughness():
    """Turbulent drag, 24/Re (1 + 0.15 Re^0.687) (Schiller and Naumann 1933), by the water at its middle."""
    heavy = open_traveller("sphere:20mm", buoyancy=-0.001)
    speed = moving_speed(heavy, 2.0)
    fluid, force = heavy.scenario.fluid, 0.001 * rolling_resistance(0.02, 0.0003)
    friction = heavy.place(2.0, speed).friction_velocity()
    # The logarithmic law, 10 mm from the wall of a pipe of a radius of 1 m.
    there = speed + friction * (1.5 + np.log(0.01)) / 0.4
    reynolds = there * 0.02 / fluid.viscosity
    drag = 24 / reynolds * (1 + 0.15 * reynolds**0.687) * 0.5 * fluid.density * there**2 * np.pi * 0.01**2
    assert drag == pytest.approx(force, rel=0.15)


def test_slopes_hold_what_they_would_roll_back_and_weightless_bodies_never_rest():
    heavy, light = (open_traveller("sphere:45mm", buoyancy=buoyancy) for buoyancy in (-0.01, 0.01))
    assert moving_speed(heavy, 0.3, 0.15) > moving_speed(heavy, 0.3) > moving_speed(heavy, 0.3, -0.05) > 0
    assert moving_speed(heavy, 0.3, -0.5) == moving_speed(light, 0.3, 0.5) == 0
    assert moving_speed(heavy, 0.3, 0.05) == pytest.approx(moving_speed(light, 0.3, -0.05))
    assert moving_speed(open_traveller("sphere:45mm"), 0.3, 0.5) == 0


def fly_from_rest(body, bore, speed):
    """Speed of a body at the end of 60 s, m/s, that lies on the floor of a level pipe at the begin."""
    document = body.scenario.model_dump(include={"fluid", "flow", "gusts", "contact"})
    document["flow"]["speed"], document["gusts"]["strength"] = speed, 0.0
    document |= {"pipe": {"segments": [{"start": (0, 0, 0), "end": (40.0, 0, 0), "radius": bore / 2}]}}
    document |= {"flight": {"horizon": 60.0}}
    scenario = release(body, document, 1.0, np.array([0.0, body.width / 2 - bore / 2 + 0.001]), 0.0, 0.0, np.zeros(3))
    assert scenario is not None
    [flight] = fly(body, [scenario], "")
    assert flight is not None
    return 1.0 if flight.end is End.OUTLET else float(np.linalg.norm(flight.velocity[-1, :3]))


@pytest.mark.long
def test_flown_bodies_move_from_half_this_speed_on_and_at_it_at_the_latest():
    """Lift and their tilt help them: those of 29 and 52 mm move from 0.7 and 0.5 of it."""
    for word in (WORD, "addB-tiltp-0-L-moveB-addB-tiltp-0-L-moveB-addF-tiltp-0-L-moveF"):
        body = open_traveller(word, buoyancy=-0.01)
        speed = moving_speed(body, 0.3)
        assert fly_from_rest(body, 0.3, 0.4 * speed) < 0.01 * speed
        assert fly_from_rest(body, 0.3, speed) > 0.2 * speed


def test_bodies_are_compared_by_where_they_fit_and_rest(done):
    Path("day.inp").write_text(DAY)
    words = ("bodies", "day.inp", "--release", "source", "--buoyancy", 0, "--buoyancy", -0.01, "--walks", 50)
    found = done(*words, "--map", "day.svg", "--json")
    bodies = {one["body"]: one for one in found["bodies"]}
    assert [one["diameter"] for one in found["bodies"]] == pytest.approx(np.repeat([0.045, 0.03, 0.02, 0.01], 2))
    assert bodies["sphere-45mm"]["closed"] == {"side": "too wide: 45 mm in a bore of 40 mm"}
    assert bodies["sphere-45mm"]["reach"] == pytest.approx(0.8)
    assert bodies["sphere-30mm"]["reach"] == pytest.approx(1)
    assert [bodies[f"sphere-{size}mm"]["narrowest"] for size in (45, 30)] == ["main, 300 mm", "side, 40 mm"]
    # The neutral one rides at all hours; the heavy one drags by day and rests at 0.02 m/s.
    hours = bodies["sphere-30mm-heavy-10mN"]["hours"]
    assert [hour["drags"] for hour in hours] == pytest.approx([1] * 12 + [0] * 12)
    assert [hour["stops"] for hour in hours] == pytest.approx([0] * 12 + [1] * 12)
    assert [hour["rides"] for hour in bodies["sphere-30mm"]["hours"]] == pytest.approx([1] * 24)
    assert bodies["sphere-30mm-heavy-10mN"]["worst"]["hour"] == 12
    # 50 m above the fork, less what little flow takes at night.
    assert bodies["sphere-30mm"]["pressure"] == pytest.approx(50 * 999.1 * 9.81, rel=0.01)
    assert found["use"] == "sphere-30mm-heavy-10mN"
    assert {one["node"] for one in found["catch"]} == {"fork", "narrow"}
    lines = done(*words)
    use = "use sphere-30mm-heavy-10mN, of bodies that can be made the heaviest of the widest that go as far as any"
    assert f"{use}: into 100.0 % of the 1.0 km" in lines
    assert "a hull withstands it with builder.pressure = 5.0e5" in lines


def test_a_body_that_nobody_can_make_is_not_the_one_to_use(done, fork_file):
    """In water this slow a neutral body alone goes on; one of 10 mm that weighs ten grams in the water is denser than lead."""
    Path("slow.inp").write_text(
        fork_file.read_text().replace("ahead 10 20", "ahead 10 0.2").replace("h 10 10", "h 10 0.1")
    )
    found = done("bodies", "slow.inp", "--release", "source", "--json")
    reach = {one["body"]: one["reach"] for one in found["bodies"]}
    assert reach["sphere-45mm"] == 1 and reach["sphere-45mm-heavy-1mN"] == 0
    assert "sphere-10mm-heavy-10mN" in reach and "sphere-10mm-heavy-100mN" not in reach
    assert "heavy" in found["use"]


def test_the_hull_of_an_agent_is_compared_with_the_pressure(done, fork_file):
    words = ("bodies", fork_file, "--release", "source", "--agent", WORD, "--set", "builder.pressure=3e5")
    [line] = [line for line in done(*words).splitlines() if line.startswith("the hull of ")]
    assert " fails at " in line
