"""Numbers that the engine cannot bear: sizes, masses, mesh files, time steps, stiffness, limits."""
