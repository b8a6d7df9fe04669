"""True geometry: shapes as convex pieces and surfaces, meshes, rotations, distances and sweeps."""
