from . import forces as forces
from . import path as path
from . import solver as solver
