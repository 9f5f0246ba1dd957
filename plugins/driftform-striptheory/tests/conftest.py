"""How tables get into docs/validation.md."""

from pathlib import Path
from runpy import run_path

# Fixtures of driftform's tests: with the import mode "importlib" a conftest is not importable from another folder.
_TESTS = run_path(str(Path(__file__).parents[3] / "tests" / "conftest.py"))
publish, published = _TESTS["publish"], _TESTS["published"]
