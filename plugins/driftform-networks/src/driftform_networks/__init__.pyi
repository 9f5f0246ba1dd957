import typer

from .flights.bodies import open_traveller as open_traveller
from .hydraulics.epanet import Changes as Changes
from .hydraulics.epanet import open_network as open_network
from .planning.fleets import plan_fleet as plan_fleet
from .planning.following import route as route
from .planning.following import trace as trace
from .planning.plans import plan_inspection as plan_inspection

def driftform_commands(app: typer.Typer) -> None: ...
