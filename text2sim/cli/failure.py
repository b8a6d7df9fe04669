"""What to say when a command cannot go on."""

import errno
import shlex
import sys

from text2sim.cli.output import say, say_json, say_problems
from text2sim.runtime.trouble import keep_details
from text2sim.service import exits
from text2sim.service.wording import reason
from text2sim.spec_schema.errors import MachineError, SpecError, Text2SimError

_MACHINE_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.ENOMEM, errno.EMFILE, errno.EIO})


def fail(error: Exception, *, as_json: bool) -> int:
    """Say what went wrong, and return the exit code.

    What a user can put right is said in a line or two; everything else is our bug, and goes to a file.
    """
    if isinstance(error, SpecError):
        if as_json:
            say_json({"ok": False, "problems": [problem.as_dict() for problem in error.problems]})
        else:
            say_problems(error.problems, {})
        return exits.INPUT
    if isinstance(error, Text2SimError | OSError):
        return _fail_plainly(error, as_json=as_json)
    message = f"internal error, which is our bug: {type(error).__name__}: {error}"
    details = keep_details(error)
    if as_json:
        say_json({"ok": False, "error": message, "details": details})
    else:
        say(f"text2sim: {message}", to=sys.stderr)
        if details:
            say(f"  please send us what this prints: cat {shlex.quote(details)}", to=sys.stderr)
    return exits.BUG


def _fail_plainly(error: Text2SimError | OSError, *, as_json: bool) -> int:
    code = exits.MACHINE if isinstance(error, MachineError) else exits.INPUT
    message = reason(error)
    if isinstance(error, OSError):
        code = exits.MACHINE if error.errno in _MACHINE_ERRORS else exits.INPUT
    if as_json:
        say_json({"ok": False, "error": message})
    else:
        say(f"text2sim: {message}", to=sys.stderr)
    return code
