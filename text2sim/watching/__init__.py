"""Runs a case again whenever it is saved: a warm engine, a quick painter, and a page in the browser."""
