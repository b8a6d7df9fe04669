"""Vocabulary of the language: what goes where, in words, for messages, schemas and reference pages."""
