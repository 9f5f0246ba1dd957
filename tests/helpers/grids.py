"""Velocities on a grid as other programs write them: tables, NetCDF and VTK."""

import numpy as np

NAMES = ("x", "y", "z", "u", "v", "w")


def table_of(grid):
    """Return one row for each node: its position and velocity, (n, 6)."""
    return np.concatenate([grid.nodes(), grid.velocity], axis=3).reshape(-1, 6)


def write_csv(path, table, names=NAMES):
    np.savetxt(path, table, "%.17g", ",", header=",".join(names), comments="")


def axes_of(grid):
    return [o + s * np.arange(n) for o, s, n in zip(grid.origin, grid.spacing, grid.shape, strict=True)]


def write_netcdf3(path, grid, order=(0, 1, 2)):
    from scipy.io import netcdf_file

    with netcdf_file(path, "w") as file:
        for name, values in zip("xyz", axes_of(grid), strict=True):
            file.createDimension(name, len(values))
            file.createVariable(name, "d", (name,))[:] = values
        for i, name in enumerate("uvw"):
            variable = file.createVariable(name, "d", tuple("xyz"[a] for a in order))
            variable._FillValue = -999.0
            variable[:] = np.nan_to_num(grid.velocity[..., i], nan=-999.0).transpose(order)


def write_netcdf4(path, grid, attributes=None, kind="f8", packed=lambda values: values):
    """Write a grid with attributes {variable: {key: value}}; ``packed`` turns the velocities into what is stored."""
    import netCDF4

    attributes = attributes or {}
    with netCDF4.Dataset(path, "w") as file:
        file.set_auto_maskandscale(False)
        file.createDimension("time", 1)
        for name, values in zip("xyz", axes_of(grid), strict=True):
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        for i, name in enumerate("uvw"):
            fill = attributes.get(name, {}).pop("_FillValue", None)
            variable = file.createVariable(name, kind, ("time", "z", "y", "x"), fill_value=fill)
            variable.set_auto_maskandscale(False)
            variable[:] = packed(grid.velocity[..., i].transpose(2, 1, 0)[None])
        for name, found in attributes.items():
            file[name].setncatts(found)


def make_data_set(grid, kind):
    """Return VTK's data set of a grid: an image, a rectilinear, structured or unstructured grid with vectors at its points."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkAppendFilter
    from vtkmodules.vtkFiltersGeneral import vtkImageDataToPointSet

    data = vtkImageData()
    data.SetOrigin(grid.origin)
    data.SetSpacing(grid.spacing)
    data.SetDimensions(grid.shape)
    missing = np.isnan(grid.velocity).any(axis=3, keepdims=True).astype(np.uint8)
    mask = ("vtkValidPointMask", 1 - missing) if kind == "vts" else ("vtkGhostType", 2 * missing)
    for name, values in (("U", np.nan_to_num(grid.velocity)), mask):
        array = numpy_to_vtk(values.transpose(2, 1, 0, 3).reshape(-1, values.shape[3]), deep=1)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    for step in {"vti": (), "vts": (vtkImageDataToPointSet(),), "vtu": (vtkAppendFilter(),)}[kind]:
        step.SetInputData(data)
        step.Update()
        data = step.GetOutput()
    return data


def write_vtk(path, data, mode):
    """Write a data set as VTK 9 does, legacy or XML."""
    from vtkmodules.vtkIOLegacy import vtkDataSetWriter
    from vtkmodules.vtkIOXML import vtkXMLDataSetWriter

    number = ("Ascii", "Binary", "Appended", "Version 3.0").index(mode)
    if path.suffix == ".vtk":
        writer = vtkDataSetWriter()
        writer.SetFileVersion(
            writer.VTK_LEGACY_READER_VERSION_4_2 if number == 3 else writer.VTK_LEGACY_READER_VERSION_5_1
        )
        writer.SetFileType(1 if number == 3 else number + 1)
    else:
        writer = vtkXMLDataSetWriter()
        writer.SetDataMode(number)
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    assert writer.Write()
