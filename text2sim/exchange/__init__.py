"""Export of recorded runs to formats of other programs: USD and glTF."""
