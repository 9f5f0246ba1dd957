"""Parts laid end to end: places, outlets, ways, and errors."""

import numpy as np
import pytest
from pydantic import ValidationError

from driftform.errors import InputError
from driftform.study import load_study
from driftform.water import Pipe, Scenario
from driftform.water.parts.shapes import Tee

TEE = {"kind": "tee", "branch_radius": 0.05, "share": 0.3}
WAY_OUT = {"length": 0.5, "outlet": "B"}


def pipe(*parts, **values):
    return Pipe.model_validate({"radius": 0.1, "parts": parts, **values})


def branched():
    return pipe(
        {"length": 1.0, "name": "main"},
        {"kind": "bend", "radius": 0.3, "roll_deg": 90},
        {**TEE, "branch": [{"length": 0.4}, {"kind": "bend", "radius": 0.1, "angle_deg": 45, "outlet": "B"}]},
        {"kind": "reducer", "length": 0.2, "radius": 0.07},
        {"length": 0.5, "outlet": "A"},
    )


def test_parts_follow_each_other_end_to_end_from_the_inlet():
    layout = branched().layout
    assert [placed.name for placed in layout.parts] == [
        "main",
        "bend 1",
        "tee 1",
        "straight 2",
        "bend 2",
        "reducer 1",
        "straight 3",
    ]
    for placed in layout.parts[1:]:
        before = layout.parts[placed.upstream].part.list_exits()[placed.by_branch]
        assert placed.part.entry == pytest.approx(before.centre)
        assert placed.part.radius == pytest.approx(before.radius)
        assert placed.part.axes[0] == pytest.approx(before.axes[0])
    assert [outlet.name for outlet in layout.outlets] == ["B", "A"]
    # A bend of 90 degrees to the right, and a tee whose branch leaves upward.
    assert layout.parts[2].part.axes[0] == pytest.approx([0, -1, 0])
    assert layout.parts[3].part.axes[0] == pytest.approx([0, 0, 1])
    assert [placed.flow for placed in layout.parts] == pytest.approx([1, 1, 1, 0.3, 0.3, 0.7, 0.7])


def test_a_pipe_of_straights_is_one_straight_pipe_and_flies_as_one():
    one = pipe({"length": 1.0}, {"length": 2.5}, start=[1.0, 0.0, 0.0], direction=[0.0, 3.0, 0.0])
    assert one.straight.start == (1.0, 0.0, 0.0)
    assert one.straight.end == pytest.approx((1.0, 3.5, 0.0))
    assert one.straight.radius == 0.1
    assert branched().straight is None


def test_a_segment_is_a_pipe_with_one_part():
    segment = {"start": [0, 0, 0], "end": [9.0, 0, 0], "radius": 1.0}
    layout = Pipe.model_validate({"segments": [segment]}).layout
    assert (len(layout.parts), layout.outlets[0].name, layout.narrowest) == (1, "outlet", 1.0)
    assert Pipe().layout.parts == ()


def test_a_pipe_contains_its_axes_and_nothing_far_from_them():
    built = branched()
    for placed in built.layout.parts:
        for axis in placed.part.list_axes(0.05):
            assert (built.layout.find_part(axis.points) >= 0).all()
            for share, inside in ((0.99, True), (1.01, False)):
                level = axis.points + share * axis.radii[:, None] * placed.part.axes[1]
                assert ((built.layout.find_part(level) >= 0) == inside).all() or isinstance(placed.part, Tee)
    assert not built.contains((0.5, 0.0, 0.11)) and not built.contains((-0.01, 0.0, 0.0))


def test_the_path_between_parts_leads_through_the_junction():
    layout = branched().layout
    tee, side, on = layout.parts[2].part, layout.parts[3], layout.parts[5]
    b, a = layout.outlets[0].opening.centre, layout.outlets[1].opening.centre
    up, down, leg = tee.legs
    # From the run behind the tee to outlet B, which is beyond a straight and a bend: back to the tee and up the branch.
    first, rest = layout.path_to_point(5, 4, b)
    assert first == pytest.approx(on.part.entry)
    chord = np.linalg.norm(layout.parts[4].part.entry - b)
    assert rest == pytest.approx(down + leg + 0.4 + chord)
    # From the branch to outlet A: back to the tee, along the run, through the reducer, and straight to the outlet's centre.
    first, rest = layout.path_to_point(3, 6, a)
    assert first == pytest.approx(side.part.entry)
    assert rest == pytest.approx(leg + down + 0.2 + 0.5)
    # From upstream; and straight within a part and to the next one.
    first, rest = layout.path_to_point(0, 3, side.part.entry)
    assert first == pytest.approx([1.0, 0, 0])
    assert rest == pytest.approx(0.3 * np.pi / 2 + up + leg)
    for neighbour in (3, 4):
        assert layout.path_to_point(neighbour, 4, b)[1] == 0.0


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ([{"kind": "bend", "radius": 0.1}], r"pipe.parts\[0\].radius = 0.1: the bend is tighter than its bore"),
        ([{"kind": "reducer", "length": 0.05, "radius": 0.05}], r"pipe.parts\[0\].length = 0.05: too short"),
        ([{"kind": "tee", "branch_radius": 0.2, "share": 0.1, "branch": [WAY_OUT]}], "wider than the run"),
        ([{**TEE, "fillet": 0.001, "branch": [WAY_OUT]}], "is rounded by 0.005 to 0.025 m"),
        (
            [{**TEE, "outlet": "A", "branch": [{"length": 1.0}]}],
            r"pipe.parts\[0\].branch\[0\]: the outlet at its end has no name",
        ),
        ([{**TEE, "branch": [WAY_OUT]}], r"pipe.parts\[0\]: the outlet at its end has no name"),
        ([{**TEE, "outlet": "b", "branch": [WAY_OUT]}], "has this outlet, too"),
        ([{**TEE, "outlet": "A"}], r"the branch of the tee has no parts: add at least \[\[pipe.parts.branch\]\]"),
        ([{"length": 1.0, "outlet": "A"}, {"length": 1.0}], "another part follows"),
        ([{"length": 1.0, "name": "a"}, {"length": 1.0, "name": "a"}], "another part has this name"),
    ],
)
def test_parts_that_do_not_fit_are_refused_with_their_place(parts, message):
    with pytest.raises(ValidationError, match=message):
        pipe(*parts)


@pytest.mark.parametrize(
    "parts",
    [
        # A loop that comes back to where it began, in the plane and in a vertical one.
        [{"length": 1.0}, *[{"kind": "bend", "radius": 0.2, "roll_deg": 90}, {"length": 0.4}] * 4],
        # A branch that turns back and meets the run downstream.
        [
            {
                **TEE,
                "roll_deg": 90,
                "branch": [
                    {"length": 0.2},
                    {"kind": "bend", "radius": 0.2, "roll_deg": 270, "angle_deg": 180},
                    {"length": 0.4, "outlet": "B"},
                ],
            },
            {"length": 2.0, "outlet": "A"},
        ],
        # An outlet that ends at the wall of another part.
        [
            {"length": 1.0},
            {"kind": "bend", "radius": 0.11, "roll_deg": 90, "angle_deg": 180},
            {"kind": "bend", "radius": 0.11, "roll_deg": 90},
        ],
    ],
    ids=["loop", "branch", "outlet"],
)
def test_parts_that_run_into_each_other_are_refused(parts):
    with pytest.raises(ValidationError, match="runs into"):
        pipe(*parts)


@pytest.mark.parametrize(
    "parts",
    [
        [{"length": 1.0}, {"kind": "bend", "radius": 0.11, "angle_deg": 180}, {"length": 1.0}],
        [
            {"kind": "bend", "radius": 0.2, "angle_deg": 10},
            {"length": 0.01},
            {"kind": "bend", "radius": 0.2, "angle_deg": 10},
        ],
        [{**TEE, "kind": "wye", "angle_deg": 30, "branch": [WAY_OUT]}, {"length": 3.0, "outlet": "A"}],
        [
            {"length": 1.0},
            *[{"kind": "bend", "radius": 0.2, "roll_deg": 90}, {"length": 0.4}] * 2,
            {"kind": "bend", "radius": 0.2},
            {"length": 1.0},
        ],
    ],
    ids=["hairpin", "short", "wye", "helix"],
)
def test_parts_that_pass_each_other_closely_are_accepted(parts):
    assert pipe(*parts).layout.outlets


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"parts": [WAY_OUT]}, "pipe.radius is missing"),
        ({"radius": 0.1, "parts": [WAY_OUT], "direction": [0, 0, 0]}, "pipe.direction has no length"),
        (
            {"radius": 0.1, "parts": [WAY_OUT], "segments": [{"start": [0, 0, 0], "end": [1, 0, 0], "radius": 1.0}]},
            "remove one of them",
        ),
    ],
)
def test_a_pipe_is_given_in_one_way(values, message):
    with pytest.raises(ValidationError, match=message):
        Pipe.model_validate(values)


STUDY = """base = "pipe-inspection"
[pipe]
segments = []
radius = 0.1
[[pipe.parts]]
length = 1.0
[[pipe.parts]]
kind = "tee"
branch_radius = 0.05
share = 0.3
outlet = "A"
[[pipe.parts.branch]]
kind = "bend"
radius = 0.2
outlet = "B"
[targets]
T = "B"
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("radius = 0.2", "radius = 0.01", r":14: pipe.parts\[1\].branch\[0\].radius = 0.01: the bend is tighter"),
        (
            "radius = 0.2",
            "raduis = 0.2",
            r":14: unknown key 'raduis' in \[\[pipe.parts.branch\]\]; did you mean 'radius'",
        ),
        (
            STUDY[STUDY.index("[[pipe.parts.b") : STUDY.index("[t")],
            "branch = []\n",
            r":12: pipe.parts\[1\].branch = \[\]: should",
        ),
        ('"bend"', '"bent"', r":13: pipe.parts\[1\].branch\[0\].kind = 'bent': unknown kind; did you mean 'bend'"),
    ],
)
def test_errors_name_the_line_of_the_part(tmp_path, old, new, message):
    file = tmp_path / "study.toml"
    file.write_text(STUDY.replace(old, new))
    with pytest.raises(InputError, match=message):
        load_study(str(file))


def test_a_target_may_be_an_outlet():
    tables = {"pipe": branched().model_dump(exclude_none=True), "targets": {"left": "B", "middle": [0.5, 0.0, 0.0]}}
    scenario = Scenario.model_validate(tables)
    assert scenario.target_array()[0] == pytest.approx(scenario.pipe.layout.outlets[0].opening.centre)
    assert scenario.target_points()["middle"] == (0.5, 0.0, 0.0)
    assert Scenario.model_validate(scenario.model_dump(mode="json", exclude_none=True)) == scenario
    with pytest.raises(ValidationError, match=r"targets\.left = 'C': the pipe has no such outlet"):
        Scenario.model_validate({**tables, "targets": {"left": "C"}})


@pytest.mark.parametrize(
    ("flow", "message"),
    [
        ({"kind": "developing"}, "flow.kind = 'developing'"),
        ({"acceleration": 0.1}, "flow.acceleration"),
        ({"speed": -1.0}, "flow.speed = -1"),
    ],
)
def test_flows_that_only_a_straight_pipe_can_have_are_refused(flow, message):
    with pytest.raises(ValidationError, match=message):
        Scenario.model_validate({"pipe": branched().model_dump(exclude_none=True), "flow": flow})
