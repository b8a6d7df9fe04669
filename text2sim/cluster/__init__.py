"""Many tasks on one machine or on many: a local pool of warm workers, or a Ray cluster."""
