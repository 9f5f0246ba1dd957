from . import formats as formats
from . import options as options
from .output import print_json as print_json
from .output import print_states as print_states
from .output import print_table as print_table
from .output import print_text as print_text

def main() -> None: ...
