"""Who is refused: other hosts, other origins, whoever lacks the token, and whatever is too large."""

import json
import os
import socket
from pathlib import Path

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
        status, _, answer = finished.send(
            "POST", f"/{finished.token}/api/check", body, content_type="application/json"
        )
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
    status, _, answer = finished.send(
        "POST", f"/{finished.token}/{path}", body, content_type="application/json"
    )
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
        f"take/{name}/study.toml",
        f"take/small/agents/{name}/agent.json",
        f"{name}",
    ):
        status, _, body = finished.send("GET", f"/{finished.token}/{path}")
        assert status in (403, 404, 422), path
        assert (
            b"secret" not in body.replace(b"../secret", b"").replace(b"named '", b"")
            or b"did you mean" in body
        )


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


def test_a_draft_cannot_read_files_by_its_base(finished, tmp_path):
    (tmp_path / "mine.toml").write_text("title = 'precious'")
    for base in (
        str(tmp_path / "mine.toml"),
        "/etc/passwd",
        "../pyproject.toml",
        None,
        3,
        ["pipe-inspection"],
    ):
        [line] = finished.ask("api/check", {"base": base}, status=422)["errors"]
        assert "is not a built-in scenario" in line and "precious" not in line


def test_a_draft_sets_no_table_that_names_files_or_programs(finished):
    for key in ("exporter", "recorder", "renderer", "checker", "nonsense"):
        [line] = finished.ask("api/check", {"base": "pipe-inspection", key: {}}, status=422)["errors"]
        assert f"cannot set '{key}'" in line


def test_every_answer_forbids_what_the_page_does_not_need(finished):
    for path in (
        "",
        "studio.js",
        "studio.css",
        "api/runs",
        "take/small/study.toml",
        "nothing",
        "take/small/agents/near/section.svg",
    ):
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
def test_the_token_is_for_the_owner_alone_and_holds_when_the_server_is_started_again(serve, folder: Path):
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
