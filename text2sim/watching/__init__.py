"""Watching of a case: it is simulated in a warm engine whenever it is saved, and shown in 3D in the browser."""
