"""A run to be looked at from all sides: one page for a browser, with what was recorded in it."""
