"""Benchmarks for other simulators: cases as neutral files with references, and comparisons of engines."""
