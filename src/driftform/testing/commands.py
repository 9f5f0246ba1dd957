"""Contract of commands: what a plugin adds to the command line by the hook ``driftform_commands``."""

import json
from typing import ClassVar

import typer
from typer.testing import CliRunner, Result

from driftform.cli.added import make_app, make_commands
from driftform.cli.app import Commands
from driftform.testing.contract import Contract


class CommandsContract(Contract):
    """Inherit this class, and name the hook::

        class TestMyCommands(CommandsContract):
            works = (("weigh", "--length", "0.1"),)
            fails = (("weigh", "--length", "-1"),)

            def add(self, app: typer.Typer) -> None:
                driftform_commands(app)

    Attributes:
        works: words of calls that work, without ``--json``: at least one.
        fails: words of calls with wrong input.
    """

    works: ClassVar[tuple[tuple[str, ...], ...]] = ()
    fails: ClassVar[tuple[tuple[str, ...], ...]] = ()

    def add(self, app: typer.Typer) -> None:
        """Call the hook of the plugin."""
        raise NotImplementedError

    def call(self, *words: str) -> Result:
        """Call a command as ``driftform`` does."""
        return CliRunner().invoke(make_app(self.add, Commands), list(words))

    def test_each_command_and_option_has_a_name_and_a_help_text(self) -> None:
        """A command has a name of small letters and dashes, and a sentence of help; so has each of its options."""
        waiting = list(make_commands(self.add).items())
        assert waiting
        for path, command in waiting:
            name = path.split()[-1]
            assert name == name.lower() and name.replace("-", "").isalnum(), path
            assert (command.help or "").strip(), path
            waiting += [(f"{path} {word}", inner) for word, inner in getattr(command, "commands", {}).items()]
            for parameter in command.params:
                assert getattr(parameter, "help", "text"), f"{path} {parameter.name}"

    def test_a_call_that_works_exits_with_0(self) -> None:
        """Each call of ``works`` prints something and exits with 0; with ``--json`` stdout is one JSON document."""
        assert self.works, "name at least one call that works"
        for words in self.works:
            for done in (self.call(*words), self.call(*words, "--json")):
                assert done.exit_code == 0, done.output
                assert done.stdout.strip()
            assert isinstance(json.loads(done.stdout), dict)

    def test_wrong_input_is_one_line_and_exits_with_2(self) -> None:
        """Each call of ``fails`` exits with 2, and prints one line on stderr that begins with ``error:``."""
        for words in self.fails:
            done = self.call(*words)
            assert done.exit_code == 2, done.output
            assert done.stderr.startswith("error: ") and done.stderr.count("\n") == 1
