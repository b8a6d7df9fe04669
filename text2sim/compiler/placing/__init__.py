"""Where everything starts: patterns of copies, packings, and relations between bodies."""
