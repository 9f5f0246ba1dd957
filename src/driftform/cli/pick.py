"""``driftform pick``."""

from types import SimpleNamespace

from driftform.cli.options import FILE, declare

NUMBERS = {"ignore_unknown_options": True}
"""A coordinate such as -0.9 begins like an option."""


@declare(FILE, "run", "x", "y", "z", "place", "out", "json")
def pick(given: SimpleNamespace) -> None:
    """Find the agent of a run whose flight passes closest to a point, which need not be a target.

    Searches every stored flight; the run need not be finished.
    """
    from driftform.cli.output import print_json
    from driftform.errors import InputError
    from driftform.runs.run import StoredRun
    from driftform.search.picking import find_place, write_pick

    opened = StoredRun.open(given.run, check=False)
    point = given.x, given.y, given.z
    if given.place is not None and given.x is None:
        point = find_place(given.place, opened.study.scenario.pipe)
    elif given.place is not None or None in point:
        raise InputError("a point is named by X Y Z, its coordinates in m, or by --place")
    stored, path = write_pick(opened, point, given.out)
    if given.json:
        print_json({"agent": str(path), **stored.result})
        return
    found = stored.result
    x, y, z = point
    print(
        f"evaluation {found['evaluation']} passes closest to ({x:g}, {y:g}, {z:g}) m: "
        f"{1000 * found['distance']:.1f} mm, after {found['t']:.2f} s"
    )
    print(f"agent: {path}")
