"""The language: models of a case, and how its YAML is read, checked and written."""
