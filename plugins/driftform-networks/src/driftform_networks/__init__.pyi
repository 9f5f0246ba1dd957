import typer

from .api import route as route
from .api import trace as trace
from .bodies import open_traveller as open_traveller
from .fleets import plan_fleet as plan_fleet
from .reading import open_network as open_network

def driftform_commands(app: typer.Typer) -> None: ...
