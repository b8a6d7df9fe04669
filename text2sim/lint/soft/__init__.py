"""Rules about deformable bodies: solvers, resolutions, bounds, contact models."""
