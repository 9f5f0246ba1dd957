from . import formats as formats
from . import options as options
from . import output as output
from .compare import search_repeats as search_repeats

def main() -> None: ...
