"""Two versions of a case: differences of meaning, patches on data and on text, merges."""
