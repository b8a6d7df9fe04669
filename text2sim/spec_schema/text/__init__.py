"""YAML as text: read with positions, laid out with comments, written in canonical form."""
