"""Arithmetic of `${…}`: parsed, bounded, and evaluated without running code."""
