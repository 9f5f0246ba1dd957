from . import files as files
from . import foreign as foreign
from . import notebook as notebook
from . import progress as progress
from . import rotations as rotations
from .compiled import allocating as allocating
from .compiled import compiled as compiled
from .compiled import vectorized as vectorized
