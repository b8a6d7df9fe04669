"""The language for others: the JSON Schema and the language reference, both made from the models."""
