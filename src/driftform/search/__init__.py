"""Evaluations in this process, in local processes, or on a Dask cluster; a crash costs only the genome to blame."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
