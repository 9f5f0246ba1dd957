from .control import grow_tolerance as grow_tolerance
from .error import TOLERANCE_RATIO as TOLERANCE_RATIO
from .error import Accuracy as Accuracy
from .error import IntegrationResult as IntegrationResult
from .error import fly_checked as fly_checked
from .error import greatest_distance as greatest_distance
from .error import integrate as integrate
from .error import integrate_once as integrate_once
