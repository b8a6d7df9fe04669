"""Cases as benchmarks for other simulators: neutral files with a reference, and the comparison of engines."""
