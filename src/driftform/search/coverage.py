"""The cells of a pipe that flights pass, for plugins that look for flights which differ."""

from driftform.runs.coverage import PipeGrid

__all__ = ["PipeGrid"]
