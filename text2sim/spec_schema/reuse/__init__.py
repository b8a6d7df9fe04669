"""What is laid over a case and what it is expanded from: variants, single values, sweeps, prefabs, older versions."""
