"""Exit codes."""

OK = 0
PHYSICS = 1
"""The case ran, or was compared, and did not do what was expected."""
INPUT = 2
"""Something that the user wrote is wrong."""
MACHINE = 3
"""This machine cannot do it, or not now: something is missing, in use, or at its limit of time or memory."""
BUG = 70
"""Something that we wrote is wrong."""
INTERRUPTED = 130
"""Someone stopped it."""
