"""Runs of tiny cases with bodies that deform, and what was measured in them."""
