"""Draws films of recorded states quickly: the process that `text2sim watch` keeps for it."""
