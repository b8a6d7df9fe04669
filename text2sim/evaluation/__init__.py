"""How good cases are: suites of prompts, methods that answer them, judges, scores and a report."""
