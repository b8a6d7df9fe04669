"""Reuse in a case: variants, single values, sweeps, prefabs, older versions."""
