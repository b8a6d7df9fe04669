"""Bodies as trees of links: mounts, mechanisms, chains, nets, dolls, models from files."""
