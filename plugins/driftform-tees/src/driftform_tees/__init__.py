"""driftform plugin: solves the ideal flow in tees and wyes of any shape."""
