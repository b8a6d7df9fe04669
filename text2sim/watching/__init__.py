"""Runs a case again whenever it is saved: a warm engine, and a page in the browser that shows it in 3D."""
