"""``driftform export-flow``."""

from pathlib import Path
from types import SimpleNamespace as Given

from driftform.cli import options


@options.declare(Path(__file__).with_name("export_flow.toml"), "study", "out", "spacing", "settings", "json")
def export_flow(given: Given) -> None:
    """Write the mean current in the pipe of a study on a regular grid, for Gazebo and for flow.kind = "grid".

    The file is a table with the columns timestamp, x, y, z, u, v and w. Gusts are left out.
    """
    from driftform import load_study
    from driftform.cli import output
    from driftform.errors import InputError
    from driftform.util import files
    from driftform_tees.currents import sample_current, write_current

    out = given.out
    if out.suffix.lower() != ".csv":
        raise InputError(f"--out {out}: the file is CSV; choose a name that ends in .csv")
    if out.is_dir():
        raise InputError(f"--out {out}: is a directory; choose the name of a file")
    files.check_directory(out.parent)
    scenario = load_study(given.study, given.settings or ()).scenario
    grid = sample_current(scenario, given.spacing)
    nodes = write_current(out, grid)
    flow, speed = scenario.flow, scenario.flow.speed
    warnings = ["gusts are left out: the file has the mean current"] * scenario.has_gusts
    if flow.kind == "uniform" and flow.acceleration:
        warnings.append(f"the current's acceleration of {flow.acceleration:g} m/s2 is left out")
    if given.json:
        output.print_json(
            {
                "file": str(out),
                "nodes": nodes,
                "shape": list(grid.shape),
                "origin": grid.origin.tolist(),
                "spacing": float(grid.spacing[0]),
                "speed": speed,
                "warnings": warnings,
            }
        )
        return
    shape = " x ".join(map(str, grid.shape))
    print(f"{out}: {nodes} nodes, {1000 * grid.spacing[0]:g} mm apart, of a grid of {shape}")
    print(f'read it with flow.kind = "grid", flow.file = "{out}", flow.reference = {speed:g}')
    for warning in warnings:
        output.print_text(f"warning: {warning}")
