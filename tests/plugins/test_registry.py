"""What is installed, and what is wrong with it; plugins are real ``.dist-info`` directories on the path."""

import importlib.util
import re
from importlib import metadata

import pytest

from driftform.builtin.fitness import ClosestApproach
from driftform.errors import InputError, WorkFailedError
from driftform.interfaces import SEAMS
from driftform.plugins.discovery import GROUP
from driftform.plugins.registry import Registry, registry
from driftform.study import load_study

SOUND = """
from driftform import hookimpl

@hookimpl
def driftform_fitness():
    from driftform.interfaces import Fitness
    from driftform.interfaces import Table, option

    class Options(Table):
        weight: float = option(1.0, "how much it weighs", "kg", gt=0)

    class Mine(Fitness):
        name = "{name}"

        def score(self, trajectory, scenario, agent):
            return scenario.target_array()[:, 0] * self.options.weight

    Mine.Options = Options
    return Mine
"""

HOOK = """
from driftform import hookimpl

@hookimpl
def driftform_fitness():
    from driftform.builtin.fitness import ClosestApproach
    from driftform.interfaces import Fitness
    {body}
"""


@pytest.fixture
def install(install):
    """Install modules as distributions, and return a registry that has looked for them."""

    def installed(**sources):
        install(**sources)
        return Registry()

    return installed


def row(found, name):
    (only,) = [row for row in found.contributions() if row.name == name]
    return only


def test_a_plugin_beside_ours_is_found_and_made_with_its_options(install):
    found = install(ext_sound=SOUND.format(name="mine"))
    assert row(found, "mine").distribution == "ext_sound-plugin"
    assert row(found, "mine").version == "1.0"
    assert row(found, "mine").available
    assert found.create("fitness", "mine", {"weight": 2.5}).options.weight == 2.5
    assert found.find("fitness", "closest-approach") is ClosestApproach


@pytest.mark.parametrize(
    ("seam", "typed", "meant"),
    [("simulator", "exudin", "exudyn"), ("strategy", "Paper", "paper"), ("exporter", "stll", "stl")],
)
def test_a_misspelt_name_is_an_input_error_with_a_suggestion(seam, typed, meant):
    with pytest.raises(InputError, match=f"^no {seam} is named '{typed}'; did you mean '{meant}'\\?$"):
        registry().find(seam, typed)


@pytest.mark.parametrize("installed", ["nothing", "driftform"])
def test_driftform_without_plugins_says_in_one_line_what_to_install(call, monkeypatch, installed):
    every = metadata.entry_points
    points = [point for point in every(group=GROUP) if point.dist.name == installed]
    monkeypatch.setattr(
        "importlib.metadata.entry_points", lambda group: points if group == GROUP else every(group=group)
    )
    registry.cache_clear()
    try:
        result = call("evolve", "--evaluations", "2")
    finally:
        registry.cache_clear()
    missing = f"grammar, builder, hydrodynamics, simulator, {'' if points else 'fitness, '}strategy"
    assert result.exit_code == 2 and result.stdout == ""
    assert result.stderr == (
        f"error: no plugin for {missing} is installed: in a clone of driftform run 'uv sync', "
        "elsewhere 'pip install driftform'\n"
    )


def test_two_plugins_that_claim_one_name_are_both_named(install):
    found = install(ext_one=SOUND.format(name="mine"), ext_two=SOUND.format(name="mine"))
    with pytest.raises(InputError) as caught:
        found.find("fitness", "mine")
    message = str(caught.value)
    assert "fitness 'mine' is claimed by" in message
    assert "ext_one-plugin 1.0" in message
    assert "ext_two-plugin 1.0" in message
    assert [r.distribution for r in found.seam("fitness") if r.name == "mine"] == ["ext_one-plugin", "ext_two-plugin"]


WRONG = {
    HOOK.format(body="import a_library_that_is_not_there"): "No module named 'a_library_that_is_not_there'",
    "import a_library_that_is_not_there": "No module named 'a_library_that_is_not_there'",
    "def broken(:": "SyntaxError: ",
    "x = 1": "registers nothing: ext_wrong has no hook; it needs a function such as driftform_fitness() with @hookimpl",
    "def driftform_grammar():\n    pass": "registers nothing: ext_wrong has no hook; write @hookimpl above driftform_gr",
    HOOK.format(body="pass").replace("_fitness()", "_fitnes()"): (
        "AttributeError: unknown hook driftform_fitnes; did you mean 'driftform_fitness'?"
    ),
    HOOK.format(body="return []"): "TypeError: the hook returned no class",
    HOOK.format(body="return int"): "TypeError: <class 'int'> is not a Fitness",
    HOOK.format(body="return 42"): "TypeError: the hook returned a int, expected a class or a list of classes",
    HOOK.format(body="return ['no class']"): "TypeError: 'no class' is not a Fitness",
    HOOK.format(body="return type('Half', (Fitness,), {'name': 'x'})"): "TypeError: Half does not implement score",
    # The name of another class would make both unusable.
    HOOK.format(body="return type('Heir', (ClosestApproach,), {})"): "TypeError: Heir has no name of its own",
    HOOK.format(body="raise ImportError"): "ImportError",
    HOOK.format(body="raise OSError('two\\nlines')"): "OSError: two lines",
}
"""Modules of plugins by what is wrong with them."""


@pytest.mark.parametrize("source", WRONG)
def test_what_is_wrong_with_a_plugin_is_one_line_of_its_row_and_of_what_selects_it(install, source):
    found = install(ext_wrong=source)
    broken = row(found, "ext_wrong")
    assert broken.distribution == "ext_wrong-plugin" and not broken.available
    assert broken.state.startswith(f"unavailable: {WRONG[source]}") and broken.state.isprintable()
    # Also by another name, which may be that of a class in it.
    for name in ("ext_wrong", "cma-es"):
        with pytest.raises(InputError, match=re.escape(f"is {broken.state}")):
            found.find("fitness", name)
    assert row(found, "lsystem").available and found.find("fitness", "closest-approach") is ClosestApproach


@pytest.mark.parametrize(
    ("seam", "plugin", "module"),
    [
        ("simulator", "exudyn", "exudyn"),
        ("renderer", "exudyn", "exudyn"),
        pytest.param("recorder", "robotics", "rosbags", marks=pytest.mark.peers),
        pytest.param("strategy", "ribs", "ribs", marks=pytest.mark.peers),
    ],
)
def test_a_module_that_a_plugin_imports_late_is_reported_missing_at_once(seam, plugin, module, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == module else found(name))
    [broken] = [row for row in Registry().seam(seam) if not row.available]
    assert (broken.name, broken.state) == (plugin, f"unavailable: No module named '{module}'")


OPTIONS = """
from driftform import hookimpl

@hookimpl
def driftform_{seam}():
    from pydantic import BaseModel, model_validator
    from driftform import interfaces
    from driftform.interfaces import Table, option

    class Mine(interfaces.{interface}):
        name = "mine"

        class Options({base}):
            {body}

    Mine.__abstractmethods__ = frozenset()
    return Mine
"""


CHECKED = """low: float = option(2.0, "", "m", ge=0, le=9)

            @model_validator(mode="after")
            def check(self):
                {check}"""
"""The body of options that a check of their own judges."""


def state_of(install, body, base="Table", seam="fitness"):
    source = OPTIONS.format(seam=seam, interface=SEAMS[seam].__name__, base=base, body=body)
    return row(install(ext_options=source), "ext_options").state


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (
            'radius: float = option(20.0, "", "m", ge=0.001, le=10)',
            "option 'radius' has the default 20.0: should be less than or equal to 10",
        ),
        (
            'count: int = option("many", "")',
            "option 'count' has the default 'many': should be a valid integer, unable to parse string as an integer",
        ),
        (CHECKED.format(check="raise ValueError('too low')"), "its defaults: Value error, too low"),
    ],
)
def test_a_default_that_its_own_option_refuses_is_reported_in_its_row(install, body, reason):
    assert state_of(install, body) == f"unavailable: ValueError: Options of Mine: {reason}"


@pytest.mark.parametrize(
    ("base", "seam", "expected"),
    [
        ("BaseModel", "fitness", "Table of driftform.interfaces"),
        ("dict", "fitness", "Table of driftform.interfaces"),
        ("Table", "hydrodynamics", "HydrodynamicsOptions of driftform.interfaces"),
    ],
)
def test_options_that_are_no_table_of_the_seam_are_reported_in_its_row(install, base, seam, expected):
    state = state_of(install, "pass", base, seam)
    assert state.startswith("unavailable: TypeError: Options of Mine is <class ")
    assert state.endswith(f"expected a class that derives from {expected}")


def test_a_required_option_needs_no_default(install):
    body = 'radius: float = option(..., "", "m", ge=0.001, le=10)'
    source = OPTIONS.format(seam="fitness", interface="Fitness", base="Table", body=body)
    assert row(install(ext_required=source), "mine").available


def test_a_check_of_options_that_fails_itself_names_the_plugin(install):
    body = CHECKED.format(check="return {0: self, 2.0: self}[self.low]")
    source = OPTIONS.format(seam="fitness", interface="Fitness", base="Table", body=body)
    with pytest.raises(WorkFailedError, match=r"^fitness 'mine' failed to check its options: KeyError: 5\.0"):
        install(ext_options=source).create("fitness", "mine", {"low": 5.0})


@pytest.mark.parametrize(
    ("check", "line"),
    [
        ("raise ValueError(\"'low' is too low\\n for us\")", "--set fitness.low=5.0: 'low' is too low for us"),
        ("assert self.low < 3, 'too high'", "--set fitness.low=5.0: too high"),
        ("raise ValueError", "--set fitness.low=5.0: [fitness] is refused by its plugin, which gives no reason"),
    ],
)
def test_what_a_check_of_options_says_is_one_line_of_the_study(install, monkeypatch, check, line):
    body = CHECKED.format(check=f"if self.low == 5:\n                    {check}\n                return self")
    source = OPTIONS.format(seam="fitness", interface="Fitness", base="Table", body=body)
    found = install(ext_options=source)
    monkeypatch.setattr("driftform.study.study.registry", lambda: found)
    with pytest.raises(InputError) as refusal:
        load_study("paper", ["fitness.use=mine", "fitness.low=5.0"])
    assert str(refusal.value) == line
