"""What the language takes where, in words: for messages, schemas and reference pages."""
