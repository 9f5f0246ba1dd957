"""Which genomes to evaluate next: the strategies that ship with driftform."""
