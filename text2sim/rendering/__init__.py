"""Path-traced films of recorded runs, from the run folder alone, without the engine."""
