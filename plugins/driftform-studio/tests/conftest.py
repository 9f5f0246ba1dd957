"""A server as the command starts it, a real browser, and what both see of a run."""

import http.client
import json
import os
import signal
import subprocess
import sysconfig
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from chromium import start_chromium

PROGRAM = Path(sysconfig.get_path("scripts")) / ("driftform.exe" if os.name == "nt" else "driftform")
WAIT_S = float(os.environ.get("WAIT_S", "240"))
"""Longest wait for anything, s: a machine under load compiles kernels slowly, and one with ten users waits longer."""

DRAFT = {
    "title": "A small pipe",
    "base": "pipe-inspection",
    "targets": {"near": [2.0, 0.0, 0.3], "far": [7.0, 0.0, -0.4]},
    "simulator": {"use": "native"},
    "robustness": {"conditions": 2, "finalists": 2, "checks": 20},
    "run": {"evaluations": 30, "seed": 5},
}
"""A search of a few seconds."""


class Server:
    """``driftform studio`` in a process of its own."""

    def __init__(self, folder, *options):
        self.folder = folder
        self._process = subprocess.Popen(
            [PROGRAM, "studio", folder.name, "--no-browser", "--json", *options],
            cwd=folder.parent,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        text = ""
        while not text.endswith("}\n"):
            line = self._process.stdout.readline()
            assert line, self._process.stderr and self._process.stderr.read()
            text += line
        self.address = json.loads(text)["address"]
        parts = urlsplit(self.address)
        assert parts.hostname and parts.port
        self.host, self.port, self.token = parts.hostname, parts.port, parts.path.strip("/")
        self.pid = self._process.pid

    def send(self, method, path, body=None, **headers):
        """Send a request as it is, also one that no browser would send; return status, headers and body."""
        connection = http.client.HTTPConnection(self.host, self.port, timeout=WAIT_S)
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        try:
            connection.request(method, path, body, {"host": f"{self.host}:{self.port}", **named})
            answer = connection.getresponse()
            return answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read()
        finally:
            connection.close()

    def ask(self, path, document=None, status=200):
        """Return the document that the server answers with."""
        body = None if document is None else json.dumps(document).encode()
        kind = {} if body is None else {"content_type": "application/json"}
        method = "GET" if body is None else "POST"
        found, _, answer = self.send(method, f"/{self.token}/{path}", body, **kind)
        assert found == status, answer
        return json.loads(answer)

    def perform(self, path, document):
        """Return the result of a task."""
        task = self.ask(path, document)["task"]
        state = wait_until_true(lambda: (found := self.ask(f"api/tasks/{task}"))["is_over"] and found)
        assert state["errors"] == []
        return state["result"]

    def wait_until(self, run, *states):
        """Return the status of a run once it is in one of some states."""
        return wait_until_true(lambda: (s := self.ask(f"api/runs/{run}/status"))["state"] in states and s)

    def kill(self):
        """End the server as a crash would."""
        self._process.kill()
        self.join()

    def stop(self):
        """End the server as Ctrl-C does."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(20)
            except subprocess.TimeoutExpired:
                self._process.kill()
        self.join()

    def join(self):
        """Wait for the process, and close its pipes."""
        self._process.wait()
        for pipe in (self._process.stdout, self._process.stderr):
            if pipe is not None:
                pipe.close()


def wait_until_true(find, seconds=WAIT_S):
    """Return what a function finds once it is true."""
    end = time.monotonic() + seconds
    while True:
        try:
            if found := find():
                return found
        except Exception as error:
            # An element of a page that is still being made is not there yet, or not there any more.
            if type(error).__name__ not in ("NoSuchElementException", "StaleElementReferenceException"):
                raise
        assert time.monotonic() < end, "it takes too long"
        time.sleep(0.1)


def pause_searches(folder):
    """Let no search outlive its test."""
    from driftform.runs.directory import is_worked_on

    runs = [path.parent for path in folder.glob("*/run.db")]
    for run in runs:
        if is_worked_on(run):
            (run / ".pause").touch()
    for run in runs:
        wait_until_true(lambda run=run: not is_worked_on(run))


@pytest.fixture
def folder(tmp_path):
    yield tmp_path / "runs"
    pause_searches(tmp_path / "runs")


@pytest.fixture
def serve(folder):
    """Start servers for the folder of the test."""
    servers = []

    def start(*options):
        servers.append(Server(folder, *options))
        return servers[-1]

    yield start
    for server in servers:
        server.stop()


@pytest.fixture(scope="session")
def finished_folder(tmp_path_factory):
    """A folder with one finished run, ``small``, that the command line made."""
    folder = tmp_path_factory.mktemp("studio") / "runs"
    folder.mkdir()
    import tomli_w

    (folder.parent / "small.toml").write_text(tomli_w.dumps(DRAFT), encoding="utf-8")
    command = [PROGRAM, "evolve", "small.toml", "--out", "runs/small", "--workers", "1"]
    subprocess.run(command, cwd=folder.parent, check=True, capture_output=True, timeout=4 * WAIT_S)
    return folder


@pytest.fixture(scope="session")
def finished(finished_folder):
    """A server for that folder; its run is not changed, but picks and reports are added."""
    server = Server(finished_folder)
    yield server
    server.stop()


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """Headless Chromium that reaches this machine only."""
    downloads = tmp_path_factory.mktemp("downloads")
    driver = start_chromium(
        tmp_path_factory.mktemp("profile"),
        "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
        "--lang=en-GB",
        **{"download.default_directory": str(downloads)},
    )
    driver.execute_cdp_cmd("Page.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(downloads)})
    driver.downloads = downloads
    driver.set_script_timeout(60)
    yield driver
    driver.quit()


@pytest.fixture
def wait_for():
    """Wait until a function finds something, and return it."""
    return wait_until_true


@pytest.fixture
def draft():
    """A search of a few seconds."""
    return DRAFT


@pytest.fixture
def long_draft():
    """A search that nobody waits for."""
    return {**DRAFT, "run": {"evaluations": 100_000, "seed": 5}}


@pytest.fixture
def terminal_search(folder, long_draft):
    """A search that the command line began: the run ``mine``, which exists once the test begins."""
    import tomli_w

    folder.mkdir()
    (folder.parent / "long.toml").write_text(tomli_w.dumps(long_draft), encoding="utf-8")
    command = [PROGRAM, "evolve", "long.toml", "--out", "runs/mine", "--workers", "1"]
    with subprocess.Popen(command, cwd=folder.parent, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as search:
        try:
            wait_until_true(lambda: (folder / "mine" / "run.db").exists() or search.poll() is not None)
            assert search.poll() is None, "the search ended at once"
            yield search
        finally:
            search.kill()


@pytest.fixture
def program():
    """The command line."""
    return PROGRAM
