"""Output of commands about cases."""

import sys

from text2sim.cli.output import say, say_problems
from text2sim.service.examined import Examined
from text2sim.service.phrases import shown


def say_examined(case: Examined) -> None:
    """Print the problems of a case."""
    if case.failure:
        say(f"{shown(case.path)}: {case.failure}", to=sys.stderr)
    say_problems(case.problems, case.sources)
