"""The folder of the runs: the only place that the page reads from and writes to."""

import json
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from driftform.errors import InputError, did_you_mean
from driftform.util import files

DATABASE = "run.db"
"""Name of the file of a run with all that it has found."""

ADDRESS = ".studio"
"""Name of the file that keeps the token and the port, so that an address holds when the server is started again."""

LARGEST_TEXT = 1_000_000
"""Largest text of a run that is shown, bytes."""


class RunsFolder:
    """The runs in one folder, by the names of their directories.

    Raises
    ------
    InputError
        if the folder cannot be made or written to.
    """

    def __init__(self, path: Path) -> None:
        self.path = files.make_directory(path, "FOLDER").resolve()

    def find(self, name: str) -> Path:
        """Return the directory of a run.

        Raises
        ------
        InputError
            if there is no such run directly in the folder, or a link in it leads out of it.
        """
        # A name that is no entry of the folder, such as "../x", is not one of these.
        known = {path.name: path for path in self.path.iterdir()}
        path = known.get(name)
        if path is None or not self._holds_run(path):
            raise InputError(f"no run is named '{name}' in {self.path}{did_you_mean(name, known)}")
        for entry in path.rglob("*"):
            if entry.is_symlink() and not entry.resolve().is_relative_to(path.resolve()):
                raise InputError(
                    f"{name}: {entry.relative_to(path)} is a link that leads out of the run; remove it"
                )
        return path

    def list_runs(self) -> Iterator[Path]:
        """Yield the directories of the runs."""
        yield from (path for path in sorted(self.path.iterdir()) if self._holds_run(path))

    def _holds_run(self, path: Path) -> bool:
        inside = files.is_directory(path) and path.resolve().parent == self.path
        return inside and files.is_file(path / DATABASE) and not (path / DATABASE).is_symlink()

    def read_text(self, run: Path, name: str) -> str:
        """Return a text file of a run, empty if there is none, or only a large one."""
        path = run / name
        if not files.is_file(path) or path.stat().st_size > LARGEST_TEXT:
            return ""
        return path.read_text(encoding="utf-8", errors="replace")

    def make_run_directory(self, name: str) -> Path:
        """Make the first free directory NAME-N, and return its path."""
        stem, number = files.safe_stem(name).replace(" ", "-").lower(), 1
        while True:
            path = self.path / f"{stem}-{number}"
            try:
                path.mkdir()
                return path
            except FileExistsError:
                number += 1

    def read_address(self) -> tuple[str, int]:
        """Return the token and the port that the page had here before; a new token and 0 if there are none."""
        path = self.path / ADDRESS
        try:
            # Whoever else may read the file knows the token.
            private = os.name == "nt" or not path.stat().st_mode & 0o077
            document: Any = json.loads(path.read_text(encoding="utf-8"))
            token, port = document["token"], document["port"]
            if (
                private
                and isinstance(token, str)
                and len(token) >= 32
                and token.isalnum()
                and 0 < port < 65536
            ):
                return token, int(port)
        except (OSError, ValueError, KeyError, TypeError):
            pass
        return secrets.token_hex(16), 0

    def write_address(self, token: str, port: int) -> None:
        """Keep the token and the port, for the owner alone."""
        path = self.path / ADDRESS
        path.unlink(missing_ok=True)
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(file, "w", encoding="utf-8") as text:
            json.dump({"token": token, "port": port}, text)
