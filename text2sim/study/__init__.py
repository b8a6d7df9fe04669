"""Blinded comparisons of films by people: who compares what, the page on which they do, and what they say."""
