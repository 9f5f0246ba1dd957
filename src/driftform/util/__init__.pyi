from . import files as files
from . import notebook as notebook
from . import progress as progress
from . import rotations as rotations
from .compiled import allocating as allocating
from .compiled import compiled as compiled
from .compiled import vectorized as vectorized
from .requirements import require_module as require_module
