"""Compiler: from a case to a plan, and from the plan to a Genesis program."""
