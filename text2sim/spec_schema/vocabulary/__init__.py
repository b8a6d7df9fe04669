"""Vocabulary of the language for messages, schemas and reference pages."""
