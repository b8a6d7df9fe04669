"""Layers and expansions of a case: variants, single values, sweeps, prefabs, older versions."""
