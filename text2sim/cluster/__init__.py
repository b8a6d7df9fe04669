"""Parallel tasks in a local pool of warm workers, or on a Ray cluster."""
