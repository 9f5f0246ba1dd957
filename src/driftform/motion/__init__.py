"""Motion of a rigid body in moving water: compiled kernels on plain arrays, shared by every simulator."""
