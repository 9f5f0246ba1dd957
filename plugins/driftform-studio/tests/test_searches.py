"""Searches in processes of their own: they are those of the command line, and nothing that happens to the server ends them."""

import json
import sqlite3
import subprocess

from driftform.runs.directory import is_worked_on


def rows(run):
    connection = sqlite3.connect(run / "run.db")
    try:
        found = connection.execute(
            "SELECT id, symbols, seed, failure, trajectory FROM evaluation ORDER BY id"
        ).fetchall()
        return [*found, *connection.execute("SELECT * FROM disturbed ORDER BY 1, 2, 3").fetchall()]
    finally:
        connection.close()


def read_count(run):
    connection = sqlite3.connect(f"{(run / 'run.db').resolve().as_uri()}?mode=ro", uri=True)
    try:
        return int(connection.execute("SELECT COUNT(*) FROM evaluation").fetchone()[0])
    finally:
        connection.close()


def test_a_run_of_the_page_is_that_of_the_command_line(serve, folder, finished_folder, draft, program):
    server = serve()
    name = server.ask("api/runs", {"draft": draft, "name": "A small pipe"})["run"]
    assert name == "a-small-pipe-1"
    status = server.wait_until(name, "finished", "failed")
    assert status["state"] == "finished" and status["failure"] == "" and status["done"] == 30
    assert rows(folder / name) == rows(finished_folder / "small")
    # Every command opens it.
    for command in ("report", "watch"):
        subprocess.run([program, command, folder / name], check=True, capture_output=True, timeout=600)
    given = (folder / name / "study.toml").read_text()
    assert 'title = "A small pipe"' in given and "seed = 5" in given


def test_a_run_that_the_command_line_made_is_shown_with_its_promise(finished):
    info = finished.ask("api/runs/small")
    assert info["title"] == "A small pipe" and [t["name"] for t in info["outline"]["targets"]] == ["near", "far"]
    status = finished.ask("api/runs/small/status")
    assert status["state"] == "finished"
    for target in status["targets"]:
        stored = json.loads((finished.folder / "small" / "best" / target["name"] / "agent.json").read_text())["result"]
        for key in ("nominal", "median", "p90", "evaluation"):
            assert target[key] == stored[key]
        assert len(target["curve"]) > 10 and target["curve"][-1] is not None


def test_a_search_that_the_command_line_began_can_be_watched_but_not_paused(serve, terminal_search, wait_for):
    server = serve()
    first = wait_for(lambda: (s := server.ask("api/runs/mine/status"))["done"] > 3 and s)
    assert first["state"] == "running" and not first["canPause"]
    [line] = server.ask("api/runs/mine/pause", {}, status=422)["errors"]
    assert "Ctrl-C" in line
    [line] = server.ask("api/runs/mine/resume", {}, status=422)["errors"]
    assert "works on this run already" in line
    wait_for(lambda: server.ask("api/runs/mine/status")["done"] > first["done"])
    terminal_search.kill()
    server.wait_until("mine", "paused")


def test_a_search_outlives_its_server_and_the_next_server_can_pause_and_continue_it(
    serve, folder, long_draft, wait_for
):
    first = serve()
    name = first.ask("api/runs", {"draft": long_draft, "name": "long"})["run"]
    wait_for(lambda: read_count(folder / name) > 3)
    first.kill()
    before = read_count(folder / name)
    wait_for(lambda: read_count(folder / name) > before)
    second = serve()
    status = second.ask(f"api/runs/{name}/status")
    assert status["state"] == "running" and status["canPause"] and status["done"] > before
    second.ask(f"api/runs/{name}/pause", {})
    paused = second.wait_until(name, "paused")
    assert paused["done"] >= status["done"] and paused["failure"] == ""
    assert not paused["canPause"] and not is_worked_on(folder / name)
    second.ask(f"api/runs/{name}/resume", {})
    wait_for(lambda: second.ask(f"api/runs/{name}/status")["done"] > paused["done"])


def test_two_searches_of_one_name_are_two_runs(serve, draft):
    server = serve()
    draft = {**draft, "run": {"evaluations": 4}}
    names = [server.ask("api/runs", {"draft": draft, "name": "../../Mine <b>"})["run"] for _ in range(2)]
    assert names == ["mine-_b-1", "mine-_b-2"]
    for name in names:
        server.wait_until(name, "finished")
    seeds = {server.ask(f"api/runs/{name}")["document"]["run"]["seed"] for name in names}
    assert len(seeds) == 2
    assert all(f"seed = {seed}" in "".join(server.ask(f"api/runs/{name}")["text"] for name in names) for seed in seeds)


def test_more_flights_continue_a_finished_run(serve, draft, wait_for):
    server = serve()
    draft = {**draft, "run": {"evaluations": 6, "seed": 1}, "robustness": {"conditions": 0}}
    name = server.ask("api/runs", {"draft": draft, "name": "few"})["run"]
    server.wait_until(name, "finished")
    server.ask(f"api/runs/{name}/resume", {"more": 6})
    status = wait_for(
        lambda: (s := server.ask(f"api/runs/{name}/status"))["done"] == 12 and s["state"] == "finished" and s
    )
    assert status["budget"] == 12


def test_a_run_that_cannot_begin_leaves_nothing_behind(serve, folder, draft):
    server = serve()
    for wrong in ({"targets": {}}, {"flow": {"speed": -1, "kind": "log_law"}}):
        asked = {"draft": {**draft, **wrong}, "name": "x"}
        assert server.ask("api/runs", asked, status=422)["errors"]
    assert [path.name for path in folder.iterdir()] == [".studio"]
