"""``sample``: random agents, the same for the same seed."""

import json
from pathlib import Path


def test_samples_are_those_of_their_seed(call):
    for out, seed in (("a", 3), ("b", 3), ("c", 4)):
        document = json.loads(call("sample", "--count", 3, "--seed", seed, "--out", out, "--json").stdout)
        assert document["agents"] == [str(Path(out, f"agent-000{n}.json")) for n in (1, 2, 3)]
    texts = {out: [Path(out, f"agent-000{n}.json").read_text() for n in (1, 2, 3)] for out in ("a", "b", "c")}
    assert texts["a"] == texts["b"]
    assert len({*texts["a"], *texts["c"]}) == 6


def test_more_samples_begin_with_the_same_ones(call):
    call("sample", "--count", 2, "--out", "few")
    call("sample", "--count", 5, "--out", "many")
    for name in ("agent-0001.json", "agent-0002.json"):
        assert Path("few", name).read_text() == Path("many", name).read_text()


def test_a_sample_says_why_most_of_its_misfits_cannot_be_released(call):
    arguments = ("--count", 6, "--set", "pipe.segments.0.radius=0.0125", "--set", "targets={}")
    found = json.loads(call("sample", "--out", "some", *arguments, "--json").stdout)
    text = call("sample", "--out", "same", *arguments).stdout
    assert 0 < found["failed"] <= 6
    assert "mm across, in a bore of 25 mm" in found["commonest_failure"]["reason"]
    line = f"{found['failed']} of 6 cannot be released, {found['commonest_failure']['count']} of them like this: "
    assert line in text
    assert json.loads(call("sample", "--out", "fit", "--count", 2, "--json").stdout)["commonest_failure"] is None
