from . import formats as formats
from . import options as options
from . import output as output

def main() -> None: ...
