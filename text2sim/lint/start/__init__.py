"""Rules about the start: overlaps, bodies below the ground, bodies without support."""
