"""Files of a run by which the page and its search speak to each other, whichever server began it."""

HELD = ".studio.lock"
"""Lock file of a run that a search of the page holds: it listens to :data:`PAUSE`."""

PAUSE = ".pause"
"""File of a run that asks its search to pause."""

PROGRESS = ".disturbed"
"""File of a run with the number of disturbed flights that are done, and of all."""
