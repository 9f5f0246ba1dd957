"""A design: an agent opened by name, and what can be done with it."""
