"""Checks that the names in a case mean something that is there, and fits."""
