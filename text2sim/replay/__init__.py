"""Replay of a run in 3D: a self-contained page for a browser."""
