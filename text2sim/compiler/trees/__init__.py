"""Bodies as trees of links: mounts, mechanisms, chains, nets, ragdolls, models from files."""
