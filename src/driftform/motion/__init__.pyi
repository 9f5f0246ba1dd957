from . import approach as approach
from . import forces as forces
from . import inertia as inertia
from . import integrator as integrator
from . import interpolation as interpolation
from . import stepping as stepping
from . import way as way
