from . import files as files
from . import progress as progress
from . import rotations as rotations
from .compiled import allocating as allocating
from .compiled import compiled as compiled
from .compiled import vectorized as vectorized
