"""How much of a town's pipes do floating sensors see? Needs driftform-networks: pip install "driftform[networks]"."""

from driftform_networks import open_network, open_traveller, plan_fleet, route, trace

town = open_network("Net3")  # or the path of an EPANET file

water = trace(town, "61", walks=0, steady=True)
sphere = route(town, "sphere:60mm", "61", walks=0, steady=True)
print(f"one drop of water sees {100 * water.coverage:.1f} % of the pipes, a sphere {100 * sphere.coverage:.1f} %")

fleet = plan_fleet(town, [open_traveller("sphere:60mm")], ["61"], 5, steady=True)
print(f"five spheres see {100 * fleet.coverage:.1f} %")
