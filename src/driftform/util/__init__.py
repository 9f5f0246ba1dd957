"""Files, progress, notebooks and compilation: nothing of agents or flows."""
