"""The folder of the runs: the only place that the page reads from and writes to."""

import base64
import hashlib
import os
import re
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

FILES = ".files"
"""Folder of the files that were given to designs, such as a computed current, by their contents."""

REDIRECT = "open-studio.html"
"""Page that leads the browser to the address, so that no command line holds the token; it is for the owner alone."""

MAX_TEXT = 1_000_000
"""Largest text of a run that is shown, bytes."""


class RunsFolder:
    """The runs in one folder, by the names of their directories.

    Raises InputError if the folder cannot be made or written to.
    """

    def __init__(self, path: Path) -> None:
        self.path = files.make_directory(path, "FOLDER").resolve()

    def find(self, name: str) -> Path:
        """Return the directory of a run.

        Raises InputError if there is no such run directly in the folder, or a link in it leads out of it.
        """
        # Only names of entries of the folder, not "../x".
        known = {path.name: path for path in self.path.iterdir()}
        path = known.get(name)
        if path is None or not self._holds_run(path):
            raise InputError(f"no run is named '{name}' in {self.path}{did_you_mean(name, known)}")
        for entry in path.rglob("*"):
            if entry.is_symlink() and not entry.resolve().is_relative_to(path.resolve()):
                raise InputError(f"{name}: {entry.relative_to(path)} is a link that leads out of the run; remove it")
        return path

    def list_runs(self) -> Iterator[Path]:
        """Yield the directories of the runs."""
        yield from (path for path in sorted(self.path.iterdir()) if self._holds_run(path))

    def _holds_run(self, path: Path) -> bool:
        inside = files.is_directory(path) and path.resolve().parent == self.path
        return inside and files.is_file(path / DATABASE) and not (path / DATABASE).is_symlink()

    def read_text(self, run: Path, name: str) -> str:
        """Return a text file of a run, empty if it is missing or large."""
        path = run / name
        if not files.is_file(path) or path.stat().st_size > MAX_TEXT:
            return ""
        return path.read_text(encoding="utf-8", errors="replace")

    def make_run_directory(self, name: str) -> Path:
        """Make the first free directory NAME-N, and return its path."""
        return files.make_numbered_directory(self.path, files.safe_stem(name).replace(" ", "-").lower())

    def keep_file(self, name: Any, content: Any) -> Path:
        """Keep a file that was given to a design (its ``content`` in base 64), and return its path.

        Raises InputError if name or content is invalid.
        """
        try:
            data = base64.b64decode(content, validate=True)
        except (TypeError, ValueError):
            raise InputError("the content of the file is not in base 64") from None
        if not isinstance(name, str) or Path(name).suffix.lower() not in (".csv", ".nc", ".vtk", ".vtu"):
            raise InputError(f"{name}: not a .csv, .nc, .vtk or .vtu file")
        folder = files.make_directory(self.path / FILES / hashlib.sha256(data).hexdigest()[:16], "FOLDER")
        path = folder / f"{files.safe_stem(Path(name).stem)}{Path(name).suffix.lower()}"
        self.check_file(str(path))
        files.write_whole(path, lambda part: part.write_bytes(data))
        return path

    def check_file(self, name: Any) -> None:
        """Check that a path of a design is that of a file that was given to one.

        Raises InputError if it leads elsewhere: the page reads nothing else of this machine.
        """
        kept = self.path / FILES
        if not isinstance(name, str) or "\0" in name or not Path(name).resolve().is_relative_to(kept):
            raise InputError(f"{name}: give the file to the design on the page; it opens no other files")

    def read_address(self) -> tuple[str, int]:
        """Return the token and the port that the page had here before; a new token and 0 if there are none."""
        path = self.path / ADDRESS
        try:
            # Other readers of the file would know the token.
            private = os.name == "nt" or not path.stat().st_mode & 0o077
            kept = re.fullmatch(r"(\w{32,}) (\d{1,5})", path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            kept = None
        if kept and private and 0 < int(kept[2]) < 65536:
            return kept[1], int(kept[2])
        return secrets.token_hex(16), 0

    def write_address(self, token: str, port: int) -> None:
        """Keep the token and the port, for the owner alone."""
        self._write_private(ADDRESS, f"{token} {port}")

    def write_redirect(self, address: str) -> Path:
        """Write the page that leads to an address, for the owner alone, and return its path."""
        refresh = f'<meta http-equiv="refresh" content="0; url={address}">'
        text = f'<!doctype html><meta name="referrer" content="no-referrer">{refresh}<title>driftform studio</title>'
        return self._write_private(REDIRECT, text)

    def _write_private(self, name: str, content: str) -> Path:
        path = self.path / name
        path.unlink(missing_ok=True)
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(file, "w", encoding="utf-8") as text:
            text.write(content)
        return path
