"""Datasets of runs: recipes, items, annotations, tables and shards, splits, questions."""
