"""Which genomes to evaluate next: the strategies that ship with driftform."""

from driftform.runs.coverage import PipeGrid as PipeGrid
