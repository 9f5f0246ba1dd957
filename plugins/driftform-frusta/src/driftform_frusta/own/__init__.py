"""Bodies of one's own: a profile from a file, the agent that it makes, and the core that modules grow around."""
