import typer

from .api import route as route
from .api import trace as trace
from .bodies import open_traveller as open_traveller
from .epanet import Changes as Changes
from .fleets import plan_fleet as plan_fleet
from .plans import plan_inspection as plan_inspection
from .reading import open_network as open_network

def driftform_commands(app: typer.Typer) -> None: ...
