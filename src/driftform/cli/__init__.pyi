from . import formats as formats
from . import options as options
from . import output as output
from .output import CommandResult as CommandResult
from .output import TextTable as TextTable
from .output import print_json as print_json
from .output import print_result as print_result
from .output import print_table as print_table
from .output import print_text as print_text

def main() -> None: ...
