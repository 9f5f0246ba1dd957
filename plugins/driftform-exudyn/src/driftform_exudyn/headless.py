"""Exudyn, imported so that it opens no window, says nothing, and is the same for every user."""

import contextlib
import io
import os

# Read when exudyn is imported: no window, and no settings from the user's home that would change results.
os.environ.setdefault("EXUDYN_SUPPRESS_UI_WINDOW_OPEN", "1")
os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")

with contextlib.redirect_stdout(io.StringIO()):
    import exudyn
    import exudyn.itemInterface

exudyn.config.printToConsole = False

items = exudyn.itemInterface

__all__ = ["exudyn", "items"]
