"""Runs side by side: what differed in their cases, and what that did to measures, events and films."""
