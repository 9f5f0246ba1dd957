"""From a simulated agent to a printed one that flies like it: ballast, trim, checks."""
