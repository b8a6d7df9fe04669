"""Versions of a case: what differs, what a patch may do, and git."""
