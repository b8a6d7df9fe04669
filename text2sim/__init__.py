"""text2sim: a case in YAML becomes a Genesis program, a run, and evidence."""

__version__ = "0.1.0"
