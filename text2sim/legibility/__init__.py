"""Legibility: one measure of how well things are seen, for cases before they run, for evidence, and for films."""
