"""Versions of a case: comparison, patches, and integration with git."""
