"""Exit codes."""

import errno

from text2sim.spec_schema.errors import MachineError

OK = 0
PHYSICS = 1
"""The case ran, or was compared, but did not meet its expectations."""
INPUT = 2
"""There is a mistake in the user's input."""
MACHINE = 3
"""This machine cannot do it, or not now: something is missing, in use, or exceeds its limit of time or memory."""
BUG = 70
"""There is a bug in text2sim."""
INTERRUPTED = 130
"""The command was stopped."""

_OF_THE_MACHINE = frozenset(
    {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.ENOMEM, errno.EMFILE, errno.EIO, errno.EPIPE}
    | {errno.EBADF}
)


def exit_of_error(error: Exception) -> int:
    """Return the exit code for an error that the user can fix."""
    if isinstance(error, OSError):
        return MACHINE if error.errno in _OF_THE_MACHINE else INPUT
    return MACHINE if isinstance(error, MachineError) else INPUT
