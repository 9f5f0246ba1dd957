"""Networks of EPANET files, and the flows that EPANET computes for them."""
