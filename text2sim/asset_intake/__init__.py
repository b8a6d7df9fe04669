"""Assets tried out: in tiny cases that are compiled, drawn and run like any other."""
