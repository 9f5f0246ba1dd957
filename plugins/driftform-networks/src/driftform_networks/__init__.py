"""driftform plugin: agents in the water network of a town."""
