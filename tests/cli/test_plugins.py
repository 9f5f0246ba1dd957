"""``plugins``: what is installed, and the options of each."""

import json

import pytest

BUILT_IN = {
    ("grammar", "lsystem"),
    ("builder", "frusta"),
    ("hydrodynamics", "striptheory"),
    ("simulator", "exudyn"),
    ("fitness", "closest-approach"),
    ("strategy", "paper"),
    ("strategy", "random"),
    ("exporter", "stl"),
    ("renderer", "exudyn"),
}


@pytest.mark.parametrize("args", [("plugins",), ("plugins", "list")])
def test_plugins_are_listed_by_seam_with_where_they_come_from(call, args):
    rows = json.loads(call(*args, "--json").stdout)["plugins"]
    assert {(row["seam"], row["name"]) for row in rows} >= BUILT_IN
    assert all(row.keys() == {"seam", "name", "distribution", "version", "state"} for row in rows)
    lines = call(*args).stdout.splitlines()
    assert lines[0].split() == ["seam", "name", "distribution", "version", "state"]
    assert len(lines) == 1 + len(rows)


def test_json_may_stand_before_or_after_list(call):
    for group in ("plugins", "scenarios"):
        assert json.loads(call(group, "list", "--json").stdout) == json.loads(call(group, "--json").stdout)


def test_a_plugin_of_someone_else_is_listed_and_shown(call, fakes):
    rows = json.loads(call("plugins", "--json").stdout)["plugins"]
    assert {
        "seam": "simulator",
        "name": "fake",
        "distribution": "driftform-fake",
        "version": "1.0",
        "state": "ok",
    } in rows
    text = call("plugins", "show", "fake").stdout
    assert text.startswith("simulator fake, from driftform-fake 1.0")
    assert "share of the genomes that end their process" in text


def test_the_options_of_a_plugin_are_shown_with_default_and_unit(call):
    [entry] = json.loads(call("plugins", "show", "frusta", "--json").stdout)["plugins"]
    options = {option["option"]: option for option in entry["options"]}
    assert options["hull_density"]["unit"] == "kg/m3"
    assert options["hull_density"]["default"] == 1050.0
    assert options["hull_density"]["bounds"] == "≥ 1, ≤ 30000"
    assert all(option["help"] for option in options.values())
    assert "hull_density" in call("plugins", "show", "frusta").stdout
    assert "It has no options." in call("plugins", "show", "closest-approach").stdout
