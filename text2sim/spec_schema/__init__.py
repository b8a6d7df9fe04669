"""Language of cases: models, YAML with positions, checks, canonical form."""
