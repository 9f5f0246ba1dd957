"""A draft of the page, as a study file and as a study; and which field an error belongs to."""

import tomllib

import pytest
import tomli_w

from driftform.errors import InputError
from driftform.study import load_study
from driftform_studio.draft import check_draft, load_draft, locate_errors


def errors_of(draft):
    text = tomli_w.dumps(check_draft(draft))
    with pytest.raises(InputError) as error:
        load_draft(text)
    return locate_errors([str(line) for line in error.value.args], text)


def test_the_text_is_a_study_file_that_the_command_line_reads(tmp_path):
    draft = {
        "base": "pipe-inspection",
        "title": "Mine",
        "flow": {"speed": 0.4},
        "targets": {"leak": [4, 0, -0.9]},
        "run": {"seed": 3},
    }
    text = tomli_w.dumps(check_draft(draft))
    (tmp_path / "mine.toml").write_text(text)
    study = load_study(str(tmp_path / "mine.toml"))
    assert study.document == load_draft(text).document
    assert study.scenario.flow.speed == 0.4 and study.scenario.targets == {"leak": (4, 0, -0.9)} and study.seed == 3
    assert load_draft(text).given == text


def test_what_a_field_leaves_empty_is_the_default():
    draft = check_draft(
        {"base": "pipe-inspection", "fluid": {"water_level": None, "density": 1000}, "targets": {"a": [1, None, 0, 0]}}
    )
    assert tomllib.loads(tomli_w.dumps(draft))["fluid"] == {"density": 1000}
    assert draft["targets"] == {"a": [1, 0, 0]}


@pytest.mark.parametrize(
    ("tables", "key", "words"),
    [
        ({"flow": {"speed": 500}}, "flow.speed", "should be less than or equal to 100 m/s"),
        ({"targets": {"leak": [40, 0, 0]}}, "targets.leak", "lies outside the pipe"),
        ({"targets": {"a b": [4, 0, 0]}}, "targets.a b", "must consist of letters"),
        (
            {"pipe": {"segments": [{"start": [0, 0, 0], "end": [0, 0, 0], "radius": 1}]}},
            "pipe.segments[0]",
            "same point",
        ),
        ({"flow": 7}, "flow", "table"),
        ({"flow": {"kind": "steam"}}, "flow.kind", "unknown kind"),
        ({"flow": {"whirl": 1}}, "flow.whirl", "unknown key 'whirl'"),
        ({"simulator": {"use": "magic"}}, "simulator.use", "magic"),
    ],
)
def test_an_error_of_the_core_is_shown_as_it_is_at_its_field(tables, key, words):
    [error] = errors_of({"base": "pipe-inspection", "targets": {}, **tables})
    assert words in error["line"] and error["line"].startswith("study.toml")
    assert error["key"] == key


TEE = {
    "kind": "tee",
    "branch_radius": 0.3,
    "share": 0.4,
    "branch": [{"kind": "straight", "length": 2.0, "outlet": "B"}],
}
"""A tee with its branch."""


@pytest.mark.parametrize(
    ("parts", "key", "words"),
    [
        ([{"kind": "bend", "radius": 0.1}], "pipe.parts[1].radius", "tighter than its bore"),
        ([{**TEE, "branch_radius": 3.0}], "pipe.parts[1].branch_radius", "wider than the run"),
        (
            [{**TEE, "branch": [{"kind": "bend", "radius": 0.1, "outlet": "B"}], "outlet": "A"}],
            "pipe.parts[1].branch[0].radius",
            "tighter than its bore",
        ),
        ([TEE], "pipe.parts[1]", "has no name"),
    ],
)
def test_an_error_of_a_part_is_shown_at_its_field_also_in_a_branch(parts, key, words):
    pipe = {"segments": [], "radius": 1.0, "parts": [{"kind": "straight", "length": 9.0}, *parts]}
    error = errors_of({"base": "pipe-inspection", "targets": {}, "pipe": pipe})[0]
    assert error["key"] == key and words in error["line"]


def test_an_error_names_the_line_of_the_study_that_the_page_shows():
    draft = check_draft(
        {"base": "pipe-inspection", "title": "Mine", "flow": {"kind": "log_law", "speed": 0}, "targets": {}}
    )
    [error] = errors_of(draft)
    number = int(error["line"].split(":")[1])
    assert tomli_w.dumps(draft).splitlines()[number - 1] == "speed = 0"
