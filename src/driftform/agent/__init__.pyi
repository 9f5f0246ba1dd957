from .distance import distance_from as distance_from
from .mass import hull_mass as hull_mass
from .mass import mass_properties as mass_properties
from .mass_elements import MassElement as MassElement
from .measures import measure_evaluation as measure_evaluation
from .slices import slice_solid as slice_solid
from .solids import solid_of_revolution as solid_of_revolution
