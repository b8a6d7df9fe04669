"""Legibility: a measure of how well things are visible, in cases before they run, in evidence, and in films."""
