"""Rules about bodies that deform: solvers that do not meet, grids that are too coarse, steps that are too long."""
