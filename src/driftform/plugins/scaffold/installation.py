"""The commands that install a new plugin where driftform is, by pip or by uv."""

import json
import shlex
import sys
from importlib import metadata, util
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname


def list_installation() -> list[str]:
    """Return the commands that install a new distribution where driftform is and run its tests, from its folder.

    An environment with pip takes it as any other. One without was made by uv. If it is that of a clone of driftform, the
    distribution gets an environment of its own, so that ``uv sync`` of the clone does not uninstall it.
    """
    if util.find_spec("pip") is not None:
        return ['pip install -e ".[test]"', "pytest"]
    clone = _find_clone()
    if clone is not None:
        return [f"uv add --editable {shlex.quote(str(clone))}", "uv run --extra test pytest"]
    return ['uv pip install -e ".[test]"', "pytest"]


def _find_clone() -> Path | None:
    """Return the folder of driftform's source if this environment is in it."""
    text = metadata.distribution("driftform").read_text("direct_url.json")
    origin = json.loads(text) if text else {}
    if not origin.get("dir_info", {}).get("editable"):
        return None
    folder = Path(url2pathname(urlsplit(origin["url"]).path))
    return folder if Path(sys.prefix).is_relative_to(folder) else None
