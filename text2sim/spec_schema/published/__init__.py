"""Published forms of the language: JSON Schema and language reference, generated from the models."""
