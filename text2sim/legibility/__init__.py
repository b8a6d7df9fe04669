"""How well things are seen: one way of measuring for cases before they run, for evidence, and for films."""
