"""Equations that bodies which deform should obey: a module each, with `check(lab)`, which returns rows of the table."""
