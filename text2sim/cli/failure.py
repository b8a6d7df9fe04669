"""Error messages and exit codes of failed commands."""

import shlex
import sys
from contextlib import suppress

from text2sim.cli.output import say, say_json, say_problems
from text2sim.runtime.internal_errors import keep_details
from text2sim.service import exits
from text2sim.service.phrases import user_message
from text2sim.spec_schema.errors import SpecError, Text2SimError


def fail_unheard(error: OSError) -> int:
    """Report a closed or full standard output on standard error if possible, and return the exit code."""
    with suppress(OSError):
        say(f"text2sim: standard output: {error.strerror}", to=sys.stderr)
    return exits.MACHINE


def fail(error: Exception, *, as_json: bool) -> int:
    """Report an error, and return the exit code.

    An error that the user can fix takes a line or two; any other one is a bug, and its traceback goes to a file.
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
            say(f"  please send us the output of: cat {shlex.quote(details)}", to=sys.stderr)
    return exits.BUG


def _fail_plainly(error: Text2SimError | OSError, *, as_json: bool) -> int:
    code, message = exits.exit_of_error(error), user_message(error)
    if as_json:
        say_json({"ok": False, "error": message})
    else:
        say(f"text2sim: {message}", to=sys.stderr)
    return code
