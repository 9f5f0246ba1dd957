"""Requests that are refused: of other hosts and origins, without the token, and too large ones."""

import json
import os
import shutil
import signal
import socket
import subprocess
import time
from base64 import b64encode
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest

MUST_FAIL = 403


def test_the_page_is_answered_with_its_token_and_with_no_other(finished):
    status, _, body = finished.send("GET", f"/{finished.token}/")
    assert status == 200 and body.startswith(b"<!doctype html>")
    wrong = ("0" * 32, finished.token[:-1], finished.token.upper() + "x", "", "%00", finished.token + "x")
    for path in ("/", "/api/runs", "/studio.js", *(f"/{token}/api/runs" for token in wrong)):
        status, _, body = finished.send("GET", path)
        assert status == MUST_FAIL and b"token" in body, path


def test_a_port_that_other_machines_reach_is_not_opened(finished):
    # All of 127.0.0.0/8 is this machine; a server that listens on every address would answer here too.
    with socket.socket() as other, pytest.raises(OSError):
        other.connect(("127.0.0.2", finished.port))


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "[::1]:{port}", ""]
)
def test_a_name_that_points_to_this_machine_is_not_its_address(finished, host):
    status, _, _ = finished.send("GET", f"/{finished.token}/api/runs", host=host.format(port=finished.port))
    assert status == MUST_FAIL


@pytest.mark.parametrize(
    "origin", ["https://evil.example", "null", "http://127.0.0.1", "http://127.0.0.1:1", "file://"]
)
@pytest.mark.parametrize("method", ["GET", "POST", "OPTIONS"])
def test_another_origin_is_refused_even_with_the_token(finished, origin, method):
    status, headers, _ = finished.send(
        method, f"/{finished.token}/api/runs", b"{}", origin=origin, content_type="application/json"
    )
    assert status == MUST_FAIL
    assert not [name for name in headers if name.startswith("access-control")]


def test_the_own_origin_is_not_refused(finished):
    for host in ("127.0.0.1", "localhost"):
        name = f"{host}:{finished.port}"
        status, _, _ = finished.send("GET", f"/{finished.token}/api/runs", host=name, origin=f"http://{name}")
        assert status == 200


def test_a_form_of_another_page_cannot_begin_anything(finished):
    body = json.dumps({"draft": {"base": "pipe-inspection"}}).encode()
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data"):
        status, _, _ = finished.send("POST", f"/{finished.token}/api/runs", body, content_type=kind)
        assert status == 415
    status, _, _ = finished.send("POST", f"/{finished.token}/api/runs", body)
    assert status == 415


def test_a_study_of_ten_megabytes_is_refused_before_it_is_read(finished):
    body = b'{"base": "pipe-inspection", "title": "' + b"x" * 10_000_000 + b'"}'
    try:
        status, _, answer = finished.send("POST", f"/{finished.token}/api/check", body, content_type="application/json")
    except (BrokenPipeError, ConnectionResetError):
        pass  # It hung up while the study was still on its way.
    else:
        assert status == 413 and b"1000 kB" in answer
    assert finished.send("GET", f"/{finished.token}/")[0] == 200


@pytest.mark.parametrize(
    "body", [b"", b"nonsense", b"[" * 100_000, b"\xff\xfe", b'{"base": 1e999}', b"null", b"[]", b'"x"']
)
@pytest.mark.parametrize("path", ["api/check", "api/runs", "api/runs/small/pick"])
def test_a_request_that_is_nonsense_is_refused_in_a_line(finished, path, body):
    status, _, answer = finished.send("POST", f"/{finished.token}/{path}", body, content_type="application/json")
    assert status in (400, 422)
    assert len(json.loads(answer)["errors"]) == 1


@pytest.mark.parametrize(
    "name",
    [
        "..",
        "../secret",
        "%2e%2e%2fsecret",
        "..%2fsecret",
        "/etc",
        "small/../../secret",
        "%00",
        "a" * 5000,
        "small%2f..%2f..%2fsecret",
    ],
)
def test_no_path_leads_out_of_the_folder(finished, finished_folder, name):
    secret = finished_folder.parent / "secret"
    if not secret.exists():
        secret.mkdir()
        (secret / "run.db").write_bytes((finished_folder / "small" / "run.db").read_bytes())
        (secret / "study.toml").write_text("secret")
    for path in (
        f"api/runs/{name}",
        f"api/runs/{name}/status",
        f"take/{name}/report.html",
        f"take/small/agents/{name}/section.svg",
        f"{name}",
    ):
        status, _, body = finished.send("GET", f"/{finished.token}/{path}")
        assert status in (403, 404, 405, 422), path
        assert b"secret" not in body.replace(b"../secret", b"").replace(b"named '", b"") or b"did you mean" in body


def test_a_link_that_leads_out_of_the_folder_is_not_followed(serve, folder, finished_folder, tmp_path):
    folder.mkdir()
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "note.txt").write_text("precious")
    (folder / "whole").symlink_to(finished_folder / "small")
    for name in ("study", "picks"):
        run = folder / name
        run.mkdir()
        (run / "run.db").write_bytes((finished_folder / "small" / "run.db").read_bytes())
    (folder / "study" / "study.toml").symlink_to(outside / "note.txt")
    (folder / "picks" / "picks").symlink_to(outside)
    server = serve()
    assert {row["name"] for row in server.ask("api/runs")["runs"]} == {"study", "picks"}
    for name in ("whole", "study", "picks"):
        [line] = server.ask(f"api/runs/{name}", status=422)["errors"]
        assert "no run is named" in line if name == "whole" else "leads out of the run" in line
    server.ask("api/runs/picks/pick", {"point": [4, 0, 0]}, status=422)
    assert [path.name for path in outside.iterdir()] == ["note.txt"]
    assert (outside / "note.txt").read_text() == "precious"


def test_a_draft_cannot_read_files_by_its_base_nor_set_tables_that_name_files_or_programs(finished, tmp_path):
    (tmp_path / "mine.toml").write_text("title = 'precious'")
    for base in (str(tmp_path / "mine.toml"), "/etc/passwd", "../pyproject.toml", None, 3, ["pipe-inspection"]):
        [line] = finished.ask("api/check", {"base": base}, status=422)["errors"]
        assert "is not a built-in scenario" in line and "precious" not in line
    for key in ("exporter", "recorder", "renderer", "checker", "nonsense"):
        [line] = finished.ask("api/check", {"base": "pipe-inspection", key: {}}, status=422)["errors"]
        assert f"cannot set '{key}'" in line


def test_every_answer_forbids_what_the_page_does_not_need(finished):
    for path in ("", "studio.js", "studio.css", "api/runs", "nothing", "take/small/agents/near/section.svg"):
        _, headers, _ = finished.send("GET", f"/{finished.token}/{path}")
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy and "unsafe" not in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer" and headers["cache-control"] == "no-store"
        assert "server" not in headers


def test_a_report_is_shown_in_a_sandbox_and_a_foreign_one_is_not(finished, finished_folder):
    finished.perform("api/runs/small/report", {})
    status, headers, body = finished.send("GET", f"/{finished.token}/take/small/report.html")
    assert status == 200 and b"<h1>" in body
    assert headers["content-security-policy"].startswith("sandbox allow-scripts;")
    assert "allow-same-origin" not in headers["content-security-policy"]


@pytest.mark.skipif(os.name == "nt", reason="no modes of files")
def test_the_token_is_for_the_owner_alone_and_holds_when_the_server_is_started_again(serve, folder):
    first = serve()
    file = folder / ".studio"
    assert file.stat().st_mode & 0o077 == 0
    first.kill()
    again = serve()
    assert again.address == first.address
    again.kill()
    # Others may have read it.
    file.chmod(0o644)
    assert serve().token != first.token


def test_a_second_server_of_a_folder_finds_another_port(serve):
    assert serve().port != serve().port


@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="no list of command lines")
def test_no_command_line_holds_the_token(folder, tmp_path, program, wait_for):
    # A browser that writes down what it is called with.
    called = tmp_path / "called"
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" >> {called}\n')
    browser.chmod(0o755)
    command = [program, "studio", str(folder), "--json"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env={**os.environ, "BROWSER": f"{browser} %s"}
    ) as server:
        text = ""
        while not text.endswith("}\n"):
            text += server.stdout.readline()
        address = json.loads(text)["address"]
        token = address.rstrip("/").rpartition("/")[2]
        wait_for(called.exists)
        page = Path(url2pathname(urlsplit(called.read_text().strip()).path))
        assert address in page.read_text() and page.stat().st_mode & 0o077 == 0
        lines = [path.read_bytes() for path in Path("/proc").glob("[0-9]*/cmdline")]
        assert len(lines) > 3 and not [line for line in lines if token.encode() in line]
        server.send_signal(signal.SIGINT)
    # The page is of no use without the server.
    assert not page.exists()


def test_another_port_has_another_token(serve, folder):
    first = serve()
    first.kill()
    with socket.socket() as taken:
        taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        taken.bind(("127.0.0.1", first.port))
        taken.listen()
        again = serve()
    assert again.port != first.port and again.token != first.token


@pytest.mark.parametrize(
    "half",
    [
        b"GET / HT",
        b"POST /{token}/api/check HTTP/1.1\r\nhost: {host}\r\ncontent-type: application/json\r\ncontent-length: 90\r\n\r\n{{",
        b"",
    ],
)
def test_a_request_that_is_half_sent_ends_after_ten_seconds(finished, half):
    text = half.decode().format(token=finished.token, host=f"{finished.host}:{finished.port}").encode()
    began = time.monotonic()
    with socket.create_connection((finished.host, finished.port), timeout=600) as connection:
        connection.sendall(text)
        try:
            while connection.recv(1000):
                pass
        except ConnectionResetError:
            pass
    assert 8 < time.monotonic() - began < 120
    assert finished.send("GET", f"/{finished.token}/")[0] == 200


ODD = ['"\\ud800"', "9999999999999999999", "-9999999999999999999", "1e400", "NaN", "Infinity", '{"\\udfff": 1}']


@pytest.mark.parametrize("value", ODD)
def test_half_characters_and_numbers_that_no_study_holds_are_refused_in_a_line(finished, value):
    table = f'{{"base": "pipe-inspection", "fluid": {{"density": {value}}}}}'
    for path, body in {
        "api/check": table,
        "api/examine": table,
        "api/runs": f'{{"draft": {table}}}',
        "api/runs/small/pick": f'{{"point": [{value}, 0, 0]}}',
        "api/runs/small/resume": f'{{"more": {value}}}',
        "api/runs/small/agents/near/trim": f'{{"grams": {value}}}',
        "api/files": f'{{"name": {value}, "content": ""}}',
    }.items():
        status, _, answer = finished.send(
            "POST", f"/{finished.token}/{path}", body.encode(), content_type="application/json"
        )
        assert status == 422, (path, answer)
        assert len(json.loads(answer)["errors"]) == 1
    assert finished.send("GET", f"/{finished.token}/api/runs/small/flights/9999999999999999999")[0] == 422


def test_a_draft_names_no_file_but_those_that_were_given_to_it(finished, finished_folder, tmp_path):
    grid = "x,y,z,u,v,w\n" + "".join(f"{x},{y},{z},1,0,0\n" for x in (0, 9) for y in (-1, 0, 1) for z in (-1, 0, 1))
    (tmp_path / "secret.csv").write_text(grid)
    link = finished_folder / ".files" / "link.csv"
    draft = {"base": "pipe-inspection", "flow": {"kind": "grid", "speed": 1.0}, "targets": {}}
    given = finished.ask("api/files", {"name": "../../my.csv", "content": b64encode(grid.encode()).decode()})["file"]
    assert Path(given).is_relative_to(finished_folder / ".files") and Path(given).read_text() == grid
    draft["flow"]["file"] = given
    assert "errors" in finished.ask("api/check", draft)
    link.symlink_to(tmp_path / "secret.csv")
    outside = [str(tmp_path / "secret.csv"), "/etc/passwd", "secret.csv", str(link), f"{given}/../../../secret", "", 7]
    for file in outside:
        draft["flow"]["file"] = file
        for path in ("api/check", "api/examine"):
            [line] = finished.ask(path, draft, status=422)["errors"]
            assert "it opens no other files" in line
    for name in ("x.exe", "x", 3, None):
        finished.ask("api/files", {"name": name, "content": ""}, status=422)
    finished.ask("api/files", {"name": "x.csv", "content": "?"}, status=422)
    link.unlink()
    core = {"base": "pipe-inspection", "builder": {"core": "/etc/passwd"}}
    assert "it opens no other files" in finished.ask("api/check", core, status=422)["errors"][0]


def test_a_capsule_is_a_file_that_was_given_and_is_a_profile(finished):
    def give(text):
        return {"name": "capsule.csv", "content": b64encode(text.encode()).decode(), "key": "builder.core"}

    [line] = finished.ask("api/files", give("x_mm,r_mm\n0,0\n1,hello\n"), status=422)["errors"]
    assert line == "capsule.csv: line 3 has no two numbers: '1,hello'"
    given = finished.ask("api/files", give("x_mm,r_mm\n0,6\n10,12\n50,12\n60,6\n"))
    assert given["length"] == pytest.approx(0.06)
    builder = {"core": given["file"], "core_mass": 0.025, "core_cog": 0.03}
    assert finished.ask("api/check", {"base": "pipe-inspection", "builder": builder})["errors"] == []
    [error] = finished.ask("api/check", {"base": "pipe-inspection", "builder": builder | {"core_cog": 0.07}})["errors"]
    assert error["key"].startswith("builder") and "core_cog" in error["line"]


def test_a_link_that_is_laid_while_a_run_is_open_is_not_followed(serve, folder, finished_folder, tmp_path):
    shutil.copytree(finished_folder / "small", folder / "small")
    server = serve()
    server.ask("api/runs/small/status")
    shutil.rmtree(folder / "small" / "picks", ignore_errors=True)
    (tmp_path / "outside").mkdir()
    (folder / "small" / "picks").symlink_to(tmp_path / "outside")
    for path, document in (("status", None), ("", None), ("pick", {"point": [4, 0, 0]}), ("report", {})):
        [line] = server.ask(f"api/runs/small/{path}".rstrip("/"), document, status=422)["errors"]
        assert "leads out of the run" in line
    assert not list((tmp_path / "outside").iterdir())


def test_a_file_that_is_opened_leads_to_no_other_file(serve, finished_folder):
    server = serve()
    agent = json.loads((finished_folder / "small" / "best" / "near" / "agent.json").read_text())
    agent["environment"]["flow"] = {"kind": "grid", "file": "/etc/passwd"}
    for name, text in (("a.toml", 'base = "/etc/passwd"'), ("a.json", json.dumps(agent))):
        errors = server.ask("api/designs", {"name": name, "text": text}, 422)["errors"]
        assert errors and "root:" not in str(errors), text
    assert server.ask("api/runs")["runs"] == []
