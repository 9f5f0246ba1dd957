"""Genomes of a grammar that a plugin adds are read and written as its own text."""

import json

import pytest

pytestmark = [pytest.mark.usefixtures("fakes")]

LETTERS = ("--set", "grammar.use=letters")


def test_a_genome_is_read_by_the_grammar_of_the_settings(call):
    found = call("inspect", "abcabcabcabc", *LETTERS, "--json")
    assert found.exit_code == 0, found.stderr
    assert json.loads(found.stdout)["genome"] == "abcabcabcabc"


def test_a_genome_of_the_report_can_be_copied_to_a_command(call, tmp_path):
    study = ("evolve", "paper", "--simulator", "fake", "--strategy", "random", "--target", "TP1")
    call(*study, *LETTERS, "--evaluations", 4, "--seed", 1, "--workers", 1, "--out", "run")
    genome = json.loads(call("inspect", "run:TP1", "--json").stdout)["genome"]
    assert set(genome) <= set("abc")
    assert call("report", "run").exit_code == 0
    assert f"<code>{genome}</code>" in (tmp_path / "run" / "report.html").read_text(encoding="utf-8")


def test_a_genome_that_looks_like_an_option_is_explained(call):
    result = call("inspect", "-0.5,0.2")
    assert result.exit_code == 2
    assert "put '--' before a value that begins with a minus sign, after all options" in result.stderr
    result = call("inspect", *LETTERS, "--", "-0.5,0.2")
    assert "is not a file, not RUN:TARGET and not a genome" in result.stderr
