"""YAML text: positions, comments, canonical form."""
