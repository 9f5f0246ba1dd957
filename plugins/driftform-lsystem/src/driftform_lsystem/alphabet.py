"""The symbols of the grammar (Table 1 of the paper) and the place of each class in a quintuple."""

CORE = "C"
"""The letter of the core module: the axiom, and the first symbol of every developed word."""

ADDS = ("addF", "addB")
TILTS = ("tiltp", "tiltn")
DEGREES = ("0", "1", "2")
LETTERS = ("S", "M", "L")
MOVES = ("moveF", "moveB", "moveN")

QUINTUPLE = (ADDS, TILTS, DEGREES, LETTERS, MOVES)
"""The classes of a quintuple's five symbols, in order."""

NOUNS = ("an add", "a tilt", "a degree", "a letter", "a move")
"""Names of the classes in messages."""

PLACE = {symbol: place for place, symbols in enumerate(QUINTUPLE) for symbol in symbols}
"""The place of each symbol in a quintuple, counted from 0, without the core's letter."""

OTHERS = {symbol: tuple(other for other in symbols if other != symbol) for symbols in QUINTUPLE for symbol in symbols}
"""What each symbol can change to: the others of its class. The core's letter has none."""

LETTER_PLACE = 3

RULES = (CORE, *LETTERS)
"""The rules of a genotype by the letter they rewrite, in the order they are stored."""

QUINTUPLES_PER_RULE = 3
RULE_LENGTH = QUINTUPLES_PER_RULE * len(QUINTUPLE)
GENOTYPE_LENGTH = len(RULES) * RULE_LENGTH
