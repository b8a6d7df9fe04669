"""Models of the language: one module for each section of a case and for shared parts."""
