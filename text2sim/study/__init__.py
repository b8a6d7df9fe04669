"""Blinded comparisons of films by people: assignments, the page for participants, and analysis of their answers."""
