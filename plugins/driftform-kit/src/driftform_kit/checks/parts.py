"""Units, and limits of what is read from a file."""

MM_PER_M = 1000.0

MOST_PIECES = 10_000
"""Largest number of meshes in a file, each counted as often as it is placed."""

MOST_ELEMENTS = 5_000_000
"""Largest number of triangles, and of vertices, in a file, with those of all placed copies."""

MM3_PER_M3 = 1e9


def check_counts(pieces: int, elements: int) -> None:
    """Refuse a file that a few bytes could make larger than any memory, by placing copies of copies.

    Raises
    ------
    ValueError
        if it has more than :data:`MOST_PIECES` meshes or :data:`MOST_ELEMENTS` triangles or vertices.
    """
    if pieces > MOST_PIECES:
        raise ValueError(f"places more than {MOST_PIECES} meshes")
    if elements > MOST_ELEMENTS:
        raise ValueError(f"has more than {MOST_ELEMENTS} triangles or vertices")
