"""The scripts of docs/examples: each runs in an empty folder and prints the number that it is about."""

import ast
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from shared import shared_folder

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
SCRIPTS = (
    *(
        "evolve",
        "own_fitness",
        "own_grammar",
        "own_strategy",
        "archive",
        "front",
        "reach_map",
        "junction",
        "kit",
        "calibration",
        "network",
    ),
    *("tether", "pair", "follow", "gym_ballast"),
)

pytestmark = [pytest.mark.long, pytest.mark.peers]


@pytest.fixture
def printed(tmp_path_factory, tmp_path, monkeypatch, capsys):
    """Run a script, and return the numbers of the groups of a pattern in its output, one for each match."""

    def run(script, pattern):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setenv("XDG_CACHE_HOME", str(shared_folder(tmp_path_factory, "networks")))
        runpy.run_path(str(EXAMPLES / f"{script}.py"), run_name="__main__")
        return [float(number) for number in re.findall(pattern, capsys.readouterr().out)]

    return run


def test_nine_of_ten_flights_pass_within_the_papers_five_percent(printed):
    near_tp1, near_tp8 = printed("evolve", r"by less than (\d+) mm")
    assert 20 < near_tp1 < 407
    assert 20 < near_tp8 < 360


def test_the_best_agent_sees_most_heights_of_the_pipe(printed):
    seen = printed("own_fitness", r"sees ([\d.]+) %")
    assert seen == sorted(seen) and seen[-1] == pytest.approx(79, abs=2)


def test_five_hundred_flights_pass_most_points(printed):
    [near] = printed("reach_map", r"(\d+) of 12 points")
    assert near >= 7


@pytest.mark.parametrize(
    ("script", "pattern", "expected"),
    [
        ("own_grammar", r"fitness ([\d.]+) %", pytest.approx([88], abs=2)),
        ("own_strategy", r"fitness ([\d.]+) %", pytest.approx([98], abs=2)),
        ("archive", r"(\d+) of 100 cells", pytest.approx([40], abs=8)),
        # The second is neutral, and as likely too light as too heavy: 20 flights scatter by 11 %.
        ("junction", r"(\d+) % by riser", pytest.approx([100, 50, 0], abs=25)),
        ("kit", r"ballast of ([\d.]+) g", [2.0]),
        ("calibration", r"drag ([\d.]+) times", pytest.approx([1.14], abs=0.02)),
        ("pair", r"([\d.]+) N", pytest.approx([0.089, 0.089], abs=0.005)),
        ("follow", r"TP1: ([\d.]+) %", pytest.approx([99], abs=1)),
        ("gym_ballast", r"misses by (\d+) mm", pytest.approx([5], abs=5)),
        ("network", r"five spheres see ([\d.]+) %", pytest.approx([36.7], abs=0.2)),
    ],
)
def test_a_script_prints_its_number(printed, script, pattern, expected):
    assert printed(script, pattern) == expected


def test_less_print_misses_by_more_along_the_front(printed):
    mass, miss = np.reshape(printed("front", r"([\d.]+)(?: g printed| %)"), (-1, 2)).T
    assert (np.diff(mass) >= 0).all() and (np.diff(miss) <= 0).all() and np.ptp(miss) > 10


def test_a_tether_carries_the_net_weight(printed):
    lifted, weight = printed("tether", r"([\d.]+) N")
    assert lifted == pytest.approx(weight, rel=5e-3) and weight > 0.2


def test_the_environment_passes_the_checks_of_gymnasium():
    from gymnasium.utils.env_checker import check_env

    check_env(runpy.run_path(str(EXAMPLES / "gym_ballast.py"))["BallastEnv"](), skip_render_check=True)


def test_examples_are_short_and_import_nothing_private():
    assert sorted(path.stem for path in EXAMPLES.glob("*.py")) == sorted(SCRIPTS)
    for script in SCRIPTS:
        text = (EXAMPLES / f"{script}.py").read_text(encoding="utf-8")
        assert len(text.splitlines()) <= 60, script
        assert not re.search(r"^(from|import) .*\b_\w", text, re.MULTILINE), script


def test_page_of_examples(docs, up_to_date):
    lines = [
        "# Examples",
        "",
        "Scripts to copy, from `docs/examples` of the repository; each runs as a test. [python.md](python.md) explains",
        "what they call.",
    ]
    for script in SCRIPTS:
        text = (EXAMPLES / f"{script}.py").read_text(encoding="utf-8")
        lines += ["", f"## {script.replace('_', ' ').capitalize()}", ""]
        lines += [(ast.get_docstring(ast.parse(text)) or "").split("\n\n")[0], ""]
        lines += [f"```python file=examples/{script}.py", text.rstrip(), "```"]
    up_to_date(docs / "examples.md", "\n".join(lines) + "\n")
