from . import field as field
from .factors import Calibration as Calibration
from .factors import Factors as Factors
from .pipe import Pipe as Pipe
from .pipe import Segment as Segment
from .pipe import Vector as Vector
from .scenario import Fluid as Fluid
from .scenario import Scenario as Scenario
