from . import grid_files as grid_files
from . import shapes as shapes
from . import tee_flow as tee_flow
from . import tee_store as tee_store
from . import tee_wall as tee_wall
