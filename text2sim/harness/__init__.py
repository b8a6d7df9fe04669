"""Runs programs and turns what they record into evidence."""
