"""Rules about quantities: sizes, masses, densities, mesh files, time steps, stiffness."""
