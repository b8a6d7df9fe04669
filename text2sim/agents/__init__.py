"""Roles, and the loop in which they plan, write, run, judge and decide, from words to an accepted case."""
