from .advance import Observer as Observer
from .advance import advance_run as advance_run
from .advance import search_run as search_run
from .local import LocalProcesses as LocalProcesses
from .strategies.breeding import breed as breed
