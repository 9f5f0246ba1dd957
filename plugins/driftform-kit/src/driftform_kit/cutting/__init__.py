"""The kit: a hull cut into parts that take the core and are joined again."""
