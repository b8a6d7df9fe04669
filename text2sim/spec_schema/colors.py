"""Colours by name: those of CSS, and a few materials."""

from colorsys import hls_to_rgb  # noqa: F401
