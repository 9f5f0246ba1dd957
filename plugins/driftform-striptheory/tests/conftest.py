"""How tables get into docs/validation.md."""

from pathlib import Path
from runpy import run_path

# Fixtures of driftform's own tests: with the import mode "importlib" one folder's conftest is no module of another's.
_TESTS = run_path(str(Path(__file__).parents[3] / "tests" / "conftest.py"))
publish, published = _TESTS["publish"], _TESTS["published"]
