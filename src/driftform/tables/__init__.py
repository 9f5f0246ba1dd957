"""Tables: the columns they have, and the files they are written to."""
