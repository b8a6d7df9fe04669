"""Evaluation of methods: suites of prompts, methods that answer them, judges, scores and a report."""
