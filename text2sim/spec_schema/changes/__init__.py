"""Changes between versions of a case: differences, patches on data and on text, merges."""
