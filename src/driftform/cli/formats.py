"""``--format`` and ``--bed``: names of plugins, and a printer's bed as slicers give it."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from driftform.scenario import Vector

MM_PER_M = 1000.0


def parse_formats(text: str, seam: str, example: str) -> list[str]:
    """Read ``NAME[,NAME...]`` of ``--format``, each an installed plugin of a seam.

    Raises
    ------
    InputError
        if one of them is missing, or none is named.
    """
    from driftform.errors import InputError
    from driftform.registry import registry

    names = list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise InputError(f"--format is empty; name at least one, such as {example}")
    for name in names:
        try:
            registry().find(seam, name)
        except InputError as error:
            raise InputError(f"--format {name}: {error}") from None
    return names


def parse_bed(text: str) -> "Vector":
    """Read ``X,Y,Z`` in mm as width, depth and height in m.

    Raises
    ------
    InputError
        if the text is something else.
    """
    from driftform.errors import InputError

    try:
        x, y, z = (float(side) for side in text.split(","))
    except ValueError:
        raise InputError(f"--bed {text}: should be three lengths in mm, such as 250,210,210") from None
    if not all(0 < side < 1e5 for side in (x, y, z)):
        raise InputError(f"--bed {text}: should be three lengths in mm above 0, such as 250,210,210")
    return x / MM_PER_M, y / MM_PER_M, z / MM_PER_M
