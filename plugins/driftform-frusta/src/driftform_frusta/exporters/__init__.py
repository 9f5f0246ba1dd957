"""Agent -> files of its hull, one module for each format.

Files for printers are in the printed frame of :mod:`driftform_frusta.hull`: millimetres, axis along z, fore end up,
lowest point at z = 0. A solid is written only after it was compared with the closed form of its section, because a
mesh with its cavity turned inside out is closed and manifold too, and only its volume shows the fault.
"""
