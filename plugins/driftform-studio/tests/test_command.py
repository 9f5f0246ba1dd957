"""``driftform studio`` serves the page of a folder, and says where."""

from pathlib import Path


def test_the_command_serves_the_page_and_prints_its_address(done, monkeypatch):
    served = []

    def serve(folder, port, announce, browser):
        served.append((folder, port, browser))
        announce("http://127.0.0.1:1/token/")

    monkeypatch.setattr("driftform_studio.server.serve", serve)
    told = done("studio", "mine", "--port", "8123", "--no-browser")
    assert served == [(Path("mine"), 8123, False)]
    assert told.splitlines()[0] == "driftform studio: http://127.0.0.1:1/token/"
