"""Files of a case that others made: read with suspicion, checked, and copied into the program."""
