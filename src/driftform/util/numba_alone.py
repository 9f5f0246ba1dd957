"""numba, imported without coverage.py: where that is installed, its import takes a tenth of that of numba, for nothing.

numba uses it only if ``NUMBA_JIT_COVERAGE`` is set, to report the lines of kernels that it compiled.
"""

import sys

_COVERAGE = "coverage"

if _COVERAGE in sys.modules:
    import numba
else:
    # Of a module that is None Python says that it is not installed.
    sys.modules[_COVERAGE] = None  # type: ignore[assignment]
    try:
        import numba
    finally:
        del sys.modules[_COVERAGE]

__all__ = ["numba"]
