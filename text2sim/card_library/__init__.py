"""Debug Cards: lessons from failures, and how they are found. Not built yet."""
