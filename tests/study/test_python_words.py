"""Errors of a study in the words of the function that was called, and of the command."""

import pytest

import driftform as df
from driftform.errors import InputError

WRONG = {
    "settings: 'flow.sped=0.8': ": {"settings": ["flow.sped=0.8"]},
    "settings: 'nonsense': expected key=value": {"settings": ["nonsense"]},
    "use['strategy']: no strategy is named 'nix'": {"use": {"strategy": "nix"}},
    "run['evaluations']: ": {"run": {"evaluations": -1}},
    "target: 'TPX': unknown target": {"targets": ["TPX"]},
    "calibration: 'no.toml': is not a file": {"calibration": "no.toml"},
}


@pytest.mark.parametrize("line", WRONG)
def test_an_error_names_the_argument_and_no_option(line):
    with pytest.raises(InputError) as caught:
        df.load_study("pipe-inspection", **WRONG[line])
    assert str(caught.value).startswith(line)
    assert "--" not in str(caught.value)


def test_a_design_in_other_surroundings_says_it_too():
    with pytest.raises(InputError, match=r"^settings: 'flow\.sped=1': unknown key 'sped'"):
        df.open_agent("addB-tiltn-1-M-moveB", "flow.sped=1")


def test_a_command_of_a_plugin_names_the_option(call):
    result = call("drop", "addB-tiltn-1-M-moveB", "--set", "flow.sped=1")
    assert result.exit_code == 2
    assert result.stderr.startswith("error: --set flow.sped=1: unknown key 'sped'")
