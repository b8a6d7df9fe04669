"""Deformable bodies on their way into the engine: who solves them, how fine, from what mesh, with what settings."""
