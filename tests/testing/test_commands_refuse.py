"""The contract of commands, which no plugin of ours takes, refuses what is wrong: each has one fault."""

import pytest
import typer

from driftform.cli.output import print_json
from driftform.errors import InputError
from driftform.testing import CommandsContract

JSON, MASS = typer.Option(False, "--json", help="JSON."), typer.Option(1.0, help="Mass, kg.")


def weigh(mass: float = MASS, json: bool = JSON):
    """Print a weight."""
    if mass <= 0:
        raise InputError("--mass: should be above 0")
    print_json({"weight": 1}) if json else print("1 N")


def without_help(json: bool = JSON):
    print("{}")


def without_help_of_an_option(mass: float = 1.0, json: bool = JSON):
    """Print a weight."""
    print("{}")


def lenient(mass: float = MASS, json: bool = JSON):
    """Print a weight, also of less than nothing, and never as JSON."""
    print("1 N")


@pytest.mark.parametrize(
    ("function", "name", "test"),
    [
        (weigh, "Weigh", "test_each_command_and_option_has_a_name_and_a_help_text"),
        (without_help, "weigh", "test_each_command_and_option_has_a_name_and_a_help_text"),
        (without_help_of_an_option, "weigh", "test_each_command_and_option_has_a_name_and_a_help_text"),
        (lenient, "weigh", "test_a_call_that_works_exits_with_0"),
        (lenient, "weigh", "test_wrong_input_is_one_line_and_exits_with_2"),
    ],
)
def test_a_faulty_command_is_refused(function, name, test):
    def check(function, name):
        contract = type("Mine", (CommandsContract,), {"add": lambda self, app: app.command(name)(function)})()
        contract.works, contract.fails = ((name,),), ((name, "--mass", "-1"),)
        getattr(contract, test)()

    check(weigh, "weigh")
    with pytest.raises((AssertionError, ValueError)):
        check(function, name)
