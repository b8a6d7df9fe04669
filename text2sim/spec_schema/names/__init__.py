"""Checks of the names and selectors in a case."""
