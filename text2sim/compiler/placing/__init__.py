"""Placement: patterns of copies, packings, and relations between bodies."""
