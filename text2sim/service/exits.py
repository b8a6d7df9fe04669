"""Exit codes."""

import errno

from text2sim.spec_schema.errors import MachineError

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

_OF_THE_MACHINE = frozenset(
    {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.ENOMEM, errno.EMFILE, errno.EIO, errno.EPIPE}
    | {errno.EBADF}
)


def exit_of_error(error: Exception) -> int:
    """Return with what a command ends that meets an error which its user can put right."""
    if isinstance(error, OSError):
        return MACHINE if error.errno in _OF_THE_MACHINE else INPUT
    return MACHINE if isinstance(error, MachineError) else INPUT
