"""Recorded runs in formats that other programs read: USD and glTF."""
