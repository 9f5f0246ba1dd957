"""Files, progress, notebooks and compilation; independent of agents and flows."""
