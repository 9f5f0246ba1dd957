"""The kit: a hull cut into parts that take the core and are joined again.

Each function here that fails raises a WorkFailedError, whose message has the reason why no kit can be made.
"""
