"""Asset files of a case: read as untrusted input, checked, and copied into the program."""
