"""The record of a run on disk: what was run, its states and shapes, whether its files are whole."""
