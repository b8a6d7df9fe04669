"""Path-traced films of recorded runs: everything comes from the run's folder, nothing from the engine."""
