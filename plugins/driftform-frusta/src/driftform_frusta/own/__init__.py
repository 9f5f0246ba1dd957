"""Your own bodies: a profile from a file, its agent, and the core that modules grow around."""
