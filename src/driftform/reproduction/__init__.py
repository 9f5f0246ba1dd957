"""The paper's experiment, repeated, and its tables and figures made of our own flights."""
